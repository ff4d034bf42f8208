// SPDX-License-Identifier: MIT
#include "app/live/live_feed.h"

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "capture/chunks.h"
#include "capture/header.h"

namespace poise::app {
namespace {

/// Rows of a message, and rows of bodies that have left for which a table is not made anew. Chosen.
constexpr std::size_t kRowsOfMessage = 10'000;
constexpr std::size_t kOldRows = 1000;
/// Records between two statuses, if nothing but figures has changed. Chosen: four a second.
constexpr std::uint32_t kRecordsOfStatus = 15;

WebMessage message(std::string_view type, std::string_view payload) {
  auto made = std::make_shared<WebBytes>();
  made->bytes.reserve(type.size() + payload.size());
  made->bytes += type;
  made->bytes += payload;
  return made;
}

WebMessage text(std::string json) {
  auto made = std::make_shared<WebBytes>();
  made->is_text = true;
  made->bytes = std::move(json);
  return made;
}

/// Whether a browser should know at once.
bool differs(const LiveStatus& a, const LiveStatus& b) {
  const bool weights = std::ranges::any_of(scheduler::policy_weights(), [&](const scheduler::PolicyField& field) {
    return a.policy.*field.value != b.policy.*field.value;
  });
  return weights || a.policy.kind != b.policy.kind || a.deadline_ms != b.deadline_ms || a.alpha != b.alpha ||
         a.paused != b.paused || a.bodies_asked != b.bodies_asked;
}

}  // namespace

LiveFeed::LiveFeed(const capture::CaptureHeader& header) : packer_(header.position_step_m, header.orientation_steps) {
  head_.push_back(message(capture::kHeaderChunk, capture::header_json(header)));
  for (std::size_t i = 0; i < header.shapes.size(); ++i) {
    head_.push_back(
        message(capture::kShapeChunk, capture::shape_bytes(static_cast<std::uint32_t>(i), header.shapes[i])));
  }
}

void LiveFeed::join(ClientId client) {
  clients_.emplace(client, ClientQueue(head_));
  if (run_ != 0) send_status();
}

void LiveFeed::shown(ClientId client, std::uint64_t number) {
  if (const auto found = clients_.find(client); found != clients_.end()) found->second.shown(number);
}

void LiveFeed::refuse(ClientId client, const std::string& error) {
  if (const auto found = clients_.find(client); found != clients_.end()) found->second.reply(text(error_json(error)));
}

WebMessage LiveFeed::next(ClientId client) {
  const auto found = clients_.find(client);
  return found == clients_.end() ? nullptr : found->second.next();
}

std::uint64_t LiveFeed::dropped(ClientId client) const {
  const auto found = clients_.find(client);
  return found == clients_.end() ? 0 : found->second.dropped();
}

bool LiveFeed::key_is_due() const {
  return std::ranges::any_of(clients_, [](const auto& client) { return client.second.takes_key(); });
}

bool LiveFeed::has_old_rows() const { return table_.size() > 2 * last_.bodies.size() + kOldRows; }

void LiveFeed::take(LiveRecord& record) {
  for (const LiveReply& reply : record.replies) refuse(reply.client, reply.error);
  const bool tells = run_ == 0 || differs(status_, record.status) || ++since_status_ >= kRecordsOfStatus;
  status_ = record.status;
  if (tells) send_status();
  if (record.has_frame) {
    const bool is_new = std::exchange(run_, record.run) != record.run;
    if (is_new) {
      packer_.clear();
      table_.clear();
    }
    std::swap(last_, record.frame);
    const bool is_key = is_new || is_stale_ || (++since_key_ >= kFramesBetweenKeys && (key_is_due() || has_old_rows()));
    send_frame(is_key, false);
  } else if (run_ != 0 && key_is_due()) {
    // Nothing moves, and somebody waits to see it.
    send_frame(true, true);
  }
}

void LiveFeed::send_status() {
  since_status_ = 0;
  for (auto& [client, queue] : clients_) queue.status(text(status_json(status_, queue.dropped(), clients_.size())));
}

// The table holds the bodies of the last frame alone.
void LiveFeed::renumber() {
  std::vector<capture::CapturedBody> rows;
  auto row = table_.begin();
  for (const capture::SeenBody& body : last_.bodies) {
    row = std::lower_bound(row, table_.end(), body.number,
                           [](const capture::CapturedBody& a, std::uint64_t number) { return a.number < number; });
    rows.push_back(*row);
  }
  packer_.clear();
  table_ = rows;
  last_.new_bodies = std::move(rows);
}

std::vector<WebMessage> LiveFeed::table(std::size_t from) const {
  std::vector<WebMessage> messages;
  for (std::size_t at = from; at < table_.size(); at += kRowsOfMessage) {
    const std::span rows = std::span(table_).subspan(at, std::min(kRowsOfMessage, table_.size() - at));
    messages.push_back(message(capture::kBodiesChunk, capture::bodies_json(at, rows)));
  }
  return messages;
}

void LiveFeed::send_frame(bool is_key, bool is_repeated) {
  if (is_repeated) last_.new_bodies.clear();
  const std::size_t rows = table_.size();
  table_.insert(table_.end(), last_.new_bodies.begin(), last_.new_bodies.end());
  is_stale_ = is_stale_ || clients_.empty();
  if ((is_key && is_stale_) || ((is_key || is_stale_) && has_old_rows())) renumber();
  // Nobody looks: the table alone goes on.
  if (clients_.empty()) return;
  is_stale_ = false;
  const bool is_whole = table_.size() == last_.new_bodies.size();
  if (is_key) {
    encoder_.begin_block();
    since_key_ = 0;
  }
  std::string frame;
  capture::put(std::uint32_t{is_key}, frame);
  capture::put(sent_, frame);
  encoder_.add(packer_.pack(last_), frame);
  const WebMessage coded = message(capture::kFramesChunk, frame);
  std::vector<WebMessage> next = table(is_whole ? 0 : rows);
  next.push_back(coded);
  std::vector<WebMessage> alone;
  for (auto& [client, queue] : clients_) {
    if (!queue.waits_for_key() || !is_key) {
      queue.frame(sent_, next, is_key);
      continue;
    }
    if (alone.empty() && queue.takes_key()) {
      alone = table(0);
      alone.push_back(coded);
    }
    queue.frame(sent_, alone, is_key);
  }
  ++sent_;
}

}  // namespace poise::app
