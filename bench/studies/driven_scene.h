// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/generators.h"
#include "scene/run/run_report.h"

namespace poise::app {

/// What limits the refinement of a frame; neither: nothing.
struct FrameLimit {
  std::optional<Nanoseconds> deadline;  ///< from the start of the frame
  std::optional<std::uint64_t> work_units;
  bool may_slice = false;  ///< StepInput::may_slice
};

/// What keeps a driven scene moving, besides gravity.
struct Shake {
  double speed_mps = 0;  ///< >= 0: change of velocity of each body, once every 16 frames, in a random direction
};

/// A scene whose generated bodies come and go as a study asks. Invariant: `present_` are the first generated bodies, in
/// the order of their generators.
///
/// Two of them that are asked for the same, with the same limits of work, are the same to the bit.
class DrivenScene {
 public:
  /// Starts with the first `present` of `most` generated bodies; a tray is as large as `most` need. Must outlive it:
  /// `scene`. Refused: as SceneRun::create, and a scene with streams, whose population changes by itself.
  static Result<DrivenScene> create(const Scene& scene, const SceneRunOptions& options, std::uint64_t most,
                                    std::uint64_t present, const Shake& shake);

  /// Takes away the last bodies, or adds the next ones: each at its place in the generator, or below it as far as
  /// a quarter of its radius above what is there; where a heap has risen to its place, above that. One whose place is
  /// not free comes later. Refused: as World::add_body.
  Status set_population(std::uint64_t bodies);
  [[nodiscard]] std::uint64_t population() const { return present_.size(); }

  /// One frame. Refused: what World::step refuses.
  Result<simulation::RunFrame> step(const FrameLimit& limit, bool reference);

  /// The same in two parts, for steps that a study makes by itself in between: begin_frame shakes, moves the camera and
  /// gives the scene's input without a limit; end_frame steps. Refused likewise.
  Result<StepInput> begin_frame();
  Result<FrameReport> end_frame(const StepInput& input);
  /// Between begin_frame and end_frame it may be stepped if its state is put back.
  [[nodiscard]] World& world() { return run_.world(); }

 private:
  DrivenScene(const Scene& scene, SceneRun run, const Shake& shake)
      : scene_(&scene), run_(std::move(run)), shake_(shake) {}
  Status list_generated(std::uint64_t most, std::uint64_t seed);
  /// Where bodies fall; without gravity a direction like any other.
  [[nodiscard]] Vec3 down() const;
  /// False: its place is not free.
  Result<bool> pour(const io::GeneratedBody& body);
  Status shake_bodies();

  const Scene* scene_;
  SceneRun run_;
  Shake shake_;
  std::vector<io::GeneratedBody> generated_;
  double highest_m_ = -1e30;     ///< of their spheres, against `down`
  std::vector<ShapeId> shapes_;  ///< of bodies that are added: in the order of Scene::shapes
  std::vector<MaterialId> materials_;
  std::vector<BodyId> present_;
  std::uint64_t frame_ = 0;
};

}  // namespace poise::app
