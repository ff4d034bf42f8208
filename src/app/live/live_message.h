// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "poise/result.h"
#include "poise/scheduler/policy.h"
#include "poise/step.h"
#include "poise/types.h"

/// What a browser may ask of a live run (docs/live.md).
namespace poise::app {

/// The largest message, and limits of what it may ask for. Chosen.
inline constexpr std::size_t kMostMessageBytes = 4096;
inline constexpr std::uint64_t kMostLiveBodies = 100'000;
inline constexpr std::uint64_t kMostPoured = 10'000;
inline constexpr std::uint64_t kMostSteps = 1000;
inline constexpr double kLongestDeadlineMs = 10'000;

struct SetDeadline {
  double ms = 0;
};
struct SetAlpha {
  double value = 0;
};
struct SetWeight {
  double scheduler::Policy::*weight = nullptr;
  double value = 0;
};
struct SetPolicy {
  scheduler::PolicyKind kind = scheduler::PolicyKind::Perceptual;
};
struct SetBodies {
  std::uint64_t count = 0;  ///< dynamic ones
};
struct PourBodies {
  std::uint64_t count = 0;
};
/// Where the viewer is and looks. What is not given stays as it is; without a camera it is that of the scene, without a
/// gaze the camera's.
struct SetView {
  std::optional<std::optional<View>> camera;
  std::optional<std::optional<Vec3>> gaze;  ///< unit
};
struct SetPaused {
  bool on = false;
};
struct StepFrames {
  std::uint64_t count = 1;
};
struct StartAgain {};
/// The page has decoded this frame: for the network alone.
struct FrameShown {
  std::uint64_t number = 0;
};
using LiveMessage = std::variant<SetDeadline, SetAlpha, SetWeight, SetPolicy, SetBodies, PourBodies, SetView, SetPaused,
                                 StepFrames, StartAgain, FrameShown>;

/// Reads a message. Refused with field, value and rule: what is no message.
Result<LiveMessage> parse_live_message(std::string_view text);

}  // namespace poise::app
