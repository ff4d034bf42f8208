// SPDX-License-Identifier: MIT
#include <string>

#include "scene/made_by.h"
#include "scene_value.h"
#include "shapes.h"
#include "step_values.h"
#include "world_value.h"

namespace poise::python {

void bind_world(py::module_& module) {
  WorldClass world(module, "World", R"(A scene of rigid bodies that is stepped within a time budget.

World(settings=None, **fields): a Settings, and fields of it to be set, e.g. World(gravity_mps2=(0, 0, -9.81),
threads=2). Lengths in metres, masses in kg, times in seconds, angles in radians, quaternions as w x y z. A call
with bad arguments raises poise.Error and changes nothing. One thread at a time: while a step runs, a call of
another thread, of a cue or of a filter raises poise.Error.)");
  world.def(
      py::init([](const py::object& given, const py::kwargs& fields) {
        SettingsValue base;
        if (py::isinstance<SettingsValue>(given)) {
          base = given.cast<SettingsValue>();
        } else if (!given.is_none()) {
          throw py::type_error("settings must be a poise.Settings or None, not " + py::repr(given).cast<std::string>());
        }
        py::object settings = py::cast(base);
        set_fields(settings, fields, "World");
        return std::make_shared<WorldValue>(settings.cast<SettingsValue>());
      }),
      py::arg("settings") = py::none());
  world.def("__repr__", [](const WorldValue&) { return "<poise.World>"; });
  bind_bodies(module, world);
  bind_results(module, world);
  bind_queries(module, world);
  bind_step(world);
}

}  // namespace poise::python

PYBIND11_MODULE(_core, module) {
  namespace python = poise::python;
  module.doc() = "The compiled part of poise; import poise instead.";
  // Signatures in docstrings, and the classes, name the package.
  const pybind11::object own_name = module.attr("__name__");
  module.attr("__name__") = "poise";
  module.attr("__version__") = POISE_PYTHON_VERSION;
  module.attr("commit") = poise::io::this_build().commit;
  module.attr("scene_folders") = pybind11::make_tuple(POISE_SCENES_SOURCE_DIR, POISE_SCENES_INSTALL_DIR);
  module.def("_close", &python::WithoutLock::close, "From now on no step begins.");
  module.def("_running", &python::WithoutLock::running, "How many steps and loads are at work.");
  python::bind_host_functions(module);
  python::bind_policy(module);
  python::bind_settings(module);
  python::bind_shapes(module);
  python::bind_step_values(module);
  python::bind_world(module);
  python::bind_scene(module);
  python::bind_replay(module);
  module.attr("__name__") = own_name;
}
