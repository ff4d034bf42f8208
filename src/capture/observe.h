// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "capture/capture_writer.h"
#include "poise/scene/scene.h"

namespace poise::capture {

/// Size of the steps in which positions of a scene are captured: a thousandth of the radius of its smallest shape,
/// rounded down to one digit. 1 mm where there are planes alone.
double position_step_of(const SceneRun& run);

/// The shapes of a run, for drawing, in the order of SceneRun::shapes().
std::vector<CapturedShape> captured_shapes(const Scene& scene, const SceneRun& run);

/// The parts of a header that the scene decides: name, step, gravity, camera, materials, shapes and the steps of
/// positions.
CaptureHeader header_of(const Scene& scene, const SceneRun& run);

/// What a step reports, with the view that it had; frame and time too. Times that do not fit are the largest.
FrameFacts facts_of(const FrameReport& report, const View& view, double dt_s);
/// The facts of the start, before any step.
FrameFacts facts_of_start(const View& view);
/// `gaze_px` of these facts, for an image of this size.
void find_gaze(const View& view, const std::array<double, 2>& resolution_px, FrameFacts& facts);
/// A momentum as facts have it.
std::array<float, 3> captured_momentum(const Vec3& momentum_ns);
/// A time in the unit of facts: 100 ns.
std::uint32_t captured_time(Nanoseconds time);

/// Collects what a capture holds of the bodies after each step. Takes time in proportion to bodies and pairs, and
/// allocates only to grow.
class FrameObserver {
 public:
  /// Observes `run` for as long as it lives. With `contacts` each frame lists what touches, with `pairs` all that is
  /// near enough to be looked at.
  FrameObserver(const Scene& scene, SceneRun& run, bool contacts, bool pairs = false)
      : scene_(scene), run_(run), contacts_(contacts), pairs_(pairs) {}
  /// Fills the lists of a frame that are empty. Refused: a body that somebody else removed from the World.
  Status observe(SeenFrame& frame);
  /// In place of that for a frame that is not captured: what later frames tell of bodies that sleep since is followed.
  void find_levels();

 private:
  void find_contacts(SeenFrame& frame) const;
  void find_pairs(SeenFrame& frame) const;

  const Scene& scene_;
  SceneRun& run_;
  bool contacts_, pairs_;
  std::uint64_t next_number_ = 0;               // of bodies that were not observed yet
  std::vector<std::uint8_t> level_, priority_;  // one a slot: as a capture holds them
  std::vector<std::uint8_t> found_, seen_;      // one a slot: of the last step
  std::vector<std::uint64_t> number_;           // one a slot
};

}  // namespace poise::capture
