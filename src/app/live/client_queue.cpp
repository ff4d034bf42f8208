// SPDX-License-Identifier: MIT
#include "app/live/client_queue.h"

#include <utility>

namespace poise::app {

void ClientQueue::reply(WebMessage message) {
  if (replies_.size() == kMostReplies) replies_.pop_front();
  replies_.push_back(std::move(message));
}

void ClientQueue::frame(std::uint32_t number, const std::vector<WebMessage>& messages, bool is_key) {
  if (waits_for_key_ && !(is_key && takes_key())) {
    // Before its first frame it misses nothing.
    if (begun_) ++dropped_;
    return;
  }
  if (ahead_.size() >= kMostAhead) {
    ++dropped_;
    waits_for_key_ = true;
    // What was not begun to be sent is of no use before a key either; one that was is sent to its end.
    while (!frames_.empty() && frames_.back().sent == 0) {
      frames_.pop_back();
      ahead_.pop_back();
      ++dropped_;
    }
    return;
  }
  waits_for_key_ = false;
  begun_ = true;
  frames_.push_back({number, messages, 0});
  ahead_.push_back(number);
}

void ClientQueue::shown(std::uint64_t number) {
  // Those that wait cannot have been shown, whatever a browser says.
  while (ahead_.size() > frames_.size() && ahead_.front() <= number) ahead_.pop_front();
}

WebMessage ClientQueue::next() {
  const auto take = [](std::deque<WebMessage>& from) {
    WebMessage message = std::move(from.front());
    from.pop_front();
    return message;
  };
  if (!head_.empty()) return take(head_);
  // The messages of a frame follow each other.
  const bool inside = !frames_.empty() && frames_.front().sent > 0;
  if (!inside && !replies_.empty()) return take(replies_);
  if (!inside && status_) return std::exchange(status_, nullptr);
  if (frames_.empty()) return nullptr;
  Frame& frame = frames_.front();
  WebMessage message = std::move(frame.messages[frame.sent++]);
  if (frame.sent == frame.messages.size()) frames_.pop_front();
  return message;
}

}  // namespace poise::app
