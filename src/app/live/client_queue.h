// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "app/live/web_server.h"

namespace poise::app {

/// What waits to be sent to one browser. One that is too slow misses frames, up to a frame that can be read without
/// those before it (a key). Invariant: at most kMostAhead frames are sent or wait, and have not been shown.
class ClientQueue {
 public:
  /// Chosen: a second, so that a page is never farther behind, and what a page must have shown before it gets a
  /// key again, so that one that stands still costs the others no large frames.
  static constexpr std::size_t kMostAhead = 60;
  static constexpr std::size_t kAheadOfKey = 4;
  static constexpr std::size_t kMostReplies = 32;

  /// `head`: what stands before the first frame.
  explicit ClientQueue(const std::vector<WebMessage>& head) : head_(head.begin(), head.end()) {}

  /// Answers; beyond kMostReplies the oldest is left out.
  void reply(WebMessage message);
  /// Replaces a status that waits.
  void status(WebMessage message) { status_ = std::move(message); }

  /// Whether it can read the next frame only if that is a key.
  [[nodiscard]] bool waits_for_key() const { return waits_for_key_; }
  /// Whether it would take one now.
  [[nodiscard]] bool takes_key() const { return waits_for_key_ && ahead_.size() <= kAheadOfKey; }
  /// The next frame, as messages that belong together, the last with its number. `is_key`: they are all that is needed.
  /// Left out, and counted, where it cannot be read or there is no room.
  void frame(std::uint32_t number, const std::vector<WebMessage>& messages, bool is_key);
  /// This frame, and all before it, have been shown.
  void shown(std::uint64_t number);

  /// What is to be sent now; null for nothing.
  WebMessage next();
  /// Frames that were left out.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  struct Frame {
    std::uint32_t number = 0;
    std::vector<WebMessage> messages;
    std::size_t sent = 0;
  };

  std::deque<WebMessage> head_, replies_;
  WebMessage status_;
  std::deque<Frame> frames_;         // of which something is to be sent
  std::deque<std::uint32_t> ahead_;  // frames that were not left out and not shown
  bool waits_for_key_ = true;
  bool begun_ = false;
  std::uint64_t dropped_ = 0;
};

}  // namespace poise::app
