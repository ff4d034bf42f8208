// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "accuracy/accuracy_case.h"
#include "poise/scene/scene.h"

namespace poise::accuracy {

/// The dynamic bodies of a scene that runs, and what they were like at some moment.
class SceneWatch {
 public:
  /// Starts the scene of a file under Context::scenes, refused as read_scene and SceneRun::create do. `change` may
  /// alter what the file says.
  static Result<SceneWatch> start(const Context& context, const std::string& file,
                                  const std::function<void(Scene&)>& change = {},
                                  std::optional<std::uint64_t> bodies = {});

  StepInput input;  ///< of the next step; the scene's time step, levels and an unlimited budget by default
  FrameReport step();
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const SceneRun& run() const { return run_; }
  World& world() { return run_.world(); }
  [[nodiscard]] const std::vector<BodyId>& bodies() const { return bodies_; }
  [[nodiscard]] BodyState at(BodyId body) const;

  void remember();                       ///< what drift_m() and fallen() compare with
  [[nodiscard]] double drift_m() const;  ///< of the body that moved farthest since
  [[nodiscard]] std::size_t fallen()
      const;  ///< bodies that are lower than then by more than a tenth of their size, or not finite
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
