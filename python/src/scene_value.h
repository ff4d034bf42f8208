// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "poise/scene/scene.h"
#include "world_step.h"

namespace poise::python {

/// A scene that runs, and what Python sees of its World.
struct SceneValue {
  Scene scene;
  std::shared_ptr<SceneRun> run;
  std::shared_ptr<WorldValue> world;
  std::uint64_t frame = 0;  ///< the next one
};

/// Loads shapes without the global lock and makes the bodies of the first frame.
std::shared_ptr<SceneRun> loaded(const Scene& scene, const SceneRunOptions& options);

void bind_scene(py::module_& module);
void bind_replay(py::module_& module);

}  // namespace poise::python
