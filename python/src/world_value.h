// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "arguments.h"
#include "host_functions.h"
#include "poise/world.h"
#include "settings.h"
#include "shapes.h"
#include "step_values.h"

namespace poise::python {

/// The states of all bodies, one row a body, in order of slots. The library has no such rows itself, so they are filled
/// on request; arrays of NumPy then show them without a copy.
struct StateRows {
  std::vector<BodyId> bodies;
  std::vector<std::uint32_t> slot, generation;
  std::vector<double> position_m, orientation_wxyz, velocity_mps, angular_velocity_radps;
};

/// A World of Python: of its own, or that of a SceneRun. Invariant: while a step runs without the global lock, every
/// other call is refused.
class WorldValue {
 public:
  explicit WorldValue(const SettingsValue& settings);
  /// `owner` keeps `world` alive.
  WorldValue(std::shared_ptr<void> owner, World& world, const PolicyValue& policy);
  WorldValue(const WorldValue&) = delete;
  WorldValue& operator=(const WorldValue&) = delete;

  /// The World; raises poise.Error while it is being stepped, in a cue or by another thread.
  World& use();
  /// Steps without the global lock, and raises what a function in Python raised. A step that the library refuses raises
  /// poise.Error.
  FrameReport step(StepInput input, const BudgetValue& budget);

  SettingsValue settings();
  void set_settings(const SettingsValue& to);
  void set_filter(const py::object& function);
  /// The id of a shape in this World, to which it is added where it was not.
  ShapeId id_of(const ShapeValue& shape);
  void remove_shape(const ShapeValue& shape);
  /// Rows of all bodies now: those of the last call where the bodies are the same, else new ones.
  std::shared_ptr<StateRows> states();

 private:
  WorldSettings attached(const SettingsValue& to);

  std::unique_ptr<HostFunctions> host_ = std::make_unique<HostFunctions>();  // before what calls them
  std::shared_ptr<void> owner_;
  World* world_;
  std::map<const Shape*, ShapeId> shapes_;
  std::shared_ptr<StateRows> rows_;
  bool busy_ = false;
};

void bind_world(py::module_& module);
/// The parts of bind_world, a file each.
using WorldClass = py::class_<WorldValue, std::shared_ptr<WorldValue>>;
void bind_bodies(py::module_& module, WorldClass& world);
void bind_results(py::module_& module, WorldClass& world);
void bind_queries(py::module_& module, WorldClass& world);

}  // namespace poise::python
