// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "app/live/live_message.h"
#include "app/live/web_server.h"
#include "capture/capture_writer.h"
#include "parallel/hand_over.h"
#include "poise/scheduler/policy.h"

/// What the thread of the simulation and that of the network hand to each other.
namespace poise::app {

/// What a live run does, apart from its frames.
struct LiveStatus {
  double deadline_ms = 0;
  double alpha = 0;
  scheduler::Policy policy;
  bool paused = false;
  std::uint64_t bodies = 0;        ///< dynamic ones
  std::uint64_t bodies_asked = 0;  ///< of which some are still to come or leave
  std::uint64_t frame = 0;         ///< frames done
  /// Of the last frames, at most kRecentFrames: late ones by cause (MissCause), on time at 0.
  std::array<std::uint32_t, 6> recent{};
  double speed = 0;            ///< simulated time over time, of the last frames; 0: unknown
  double frames_a_step = 1;    ///< of the last frames: more where steps are done in slices
  std::uint64_t left_out = 0;  ///< frames for which the network had no room
};
inline constexpr std::size_t kRecentFrames = 300;

/// An answer to one browser.
struct LiveReply {
  ClientId client = 0;
  std::string error;
};

/// Told after each frame, and from time to time where there is none.
struct LiveRecord {
  std::uint64_t run = 0;  ///< counts starts of the scene: numbers of bodies and frames begin again
  bool has_frame = false;
  capture::SeenFrame frame;
  LiveStatus status;
  std::vector<LiveReply> replies;
};

/// What a browser asks for, checked.
struct LiveRequest {
  ClientId client = 0;
  LiveMessage message;
};

/// Between the two threads. Neither waits for the other.
struct LiveLink {
  /// Chosen: half a second of frames, and what many mice say in a long frame.
  static constexpr std::size_t kRecordsWaiting = 30;
  static constexpr std::size_t kRequestsWaiting = 256;
  parallel::HandOver<LiveRecord> records{kRecordsWaiting};
  parallel::HandOver<LiveRequest> requests{kRequestsWaiting};
};

/// The status as a message for one browser.
std::string status_json(const LiveStatus& status, std::uint64_t frames_dropped, std::size_t browsers);
/// An error as a message.
std::string error_json(const std::string& error);

}  // namespace poise::app
