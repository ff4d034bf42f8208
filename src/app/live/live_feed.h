// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "app/live/client_queue.h"
#include "app/live/live_record.h"
#include "capture/capture.h"
#include "capture/frame_code.h"
#include "capture/frame_packer.h"

namespace poise::app {

/// Makes of the records of a run what each browser is sent (docs/live.md). All share one code of frames; a browser that
/// comes, or was too slow, gets the table of bodies and a frame that can be read without those before it.
///
/// One thread. It knows no connections: `next` says what is to be sent.
class LiveFeed {
 public:
  /// Chosen: a frame that can be read alone is many times as large as others.
  static constexpr std::uint32_t kFramesBetweenKeys = 15;

  explicit LiveFeed(const capture::CaptureHeader& header);

  void join(ClientId client);
  void leave(ClientId client) { clients_.erase(client); }
  /// Takes what is of use of a record, and leaves memory in it to be used again.
  void take(LiveRecord& record);
  void shown(ClientId client, std::uint64_t number);
  void refuse(ClientId client, const std::string& error);
  /// What is to be sent to a browser now; null for nothing.
  WebMessage next(ClientId client);
  /// Frames that a browser missed since it came.
  [[nodiscard]] std::uint64_t dropped(ClientId client) const;

 private:
  [[nodiscard]] bool key_is_due() const;
  [[nodiscard]] bool has_old_rows() const;
  void send_frame(bool is_key, bool is_repeated);
  void send_status();
  void renumber();
  [[nodiscard]] std::vector<WebMessage> table(std::size_t from) const;

  std::vector<WebMessage> head_;
  capture::FramePacker packer_;
  capture::FrameEncoder encoder_{false};
  std::vector<capture::CapturedBody> table_;  // by row
  std::map<ClientId, ClientQueue> clients_;
  capture::SeenFrame last_;
  bool is_stale_ = false;  // frames were not coded, since nobody looked
  LiveStatus status_;
  std::uint64_t run_ = 0;        // of the last frame; 0: there was none
  std::uint32_t sent_ = 0;       // frames: number of the next
  std::uint32_t since_key_ = 0;  // frames
  std::uint32_t since_status_ = 0;
};

}  // namespace poise::app
