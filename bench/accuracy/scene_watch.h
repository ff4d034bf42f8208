// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "accuracy/accuracy_case.h"
#include "poise/scene/scene.h"

namespace poise::accuracy {

/// The dynamic bodies of a running scene, and their state at a remembered moment.
class SceneWatch {
 public:
  /// Starts the scene of a file under Context::scenes. `change` may alter the parsed scene. With `seeds_on` its
  /// seed is that of the file and so many more. Refused as read_scene and SceneRun::create.
  static Result<SceneWatch> start(const Context& context, const std::string& file,
                                  const std::function<void(Scene&)>& change = {},
                                  std::optional<std::uint64_t> bodies = {}, std::uint64_t seeds_on = 0);

  StepInput input;  ///< of the next step; the scene's time step, levels and an unlimited budget by default
  FrameReport step();
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const SceneRun& run() const { return run_; }
  World& world() { return run_.world(); }
  [[nodiscard]] const std::vector<BodyId>& bodies() const { return bodies_; }
  [[nodiscard]] BodyState at(BodyId body) const;

  void remember();                       ///< stores the state that drift_m() and fallen() compare with
  [[nodiscard]] double drift_m() const;  ///< of the body that moved farthest since
  /// Bodies that have sunk by more than a tenth of their size since, or are not finite.
  [[nodiscard]] std::size_t fallen() const;
  [[nodiscard]] double kinetic_j() const;
  [[nodiscard]] double energy_j() const;  ///< kinetic and potential, potential 0 at height 0
  [[nodiscard]] double largest_speed_mps() const;
  [[nodiscard]] double mean_height_m() const;   ///< of the centres of mass above the floor z = 0
  [[nodiscard]] double weight_scale_j() const;  ///< sum of m g R, with R the radius about the centre of mass
  [[nodiscard]] std::size_t outside() const;    ///< bodies outside the tray or below its floor, or not finite
  [[nodiscard]] std::uint64_t frames_of(double seconds) const;

 private:
  SceneWatch(Scene scene, SceneRun run);
  Scene scene_;
  SceneRun run_;
  std::vector<BodyId> bodies_;
  std::vector<Vec3> then_;
  std::uint64_t frame_ = 0;
};

}  // namespace poise::accuracy
