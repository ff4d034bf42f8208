// SPDX-License-Identifier: MIT
#include "scene_value.h"

#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <utility>

namespace poise::python {
namespace {

std::optional<std::uint64_t> optional_whole(const char* name, const py::object& given) {
  if (given.is_none()) return std::nullopt;
  return whole_of(name, given, ~std::uint64_t{0});
}

/// As `poise run` makes them: what the scene says, then what the caller says.
SettingsValue settings_of(const Scene& scene, const py::kwargs& fields) {
  SettingsValue value;
  value.policy.policy = scene.policy;
  value.settings.alpha = scene.alpha.value_or(value.settings.alpha);
  value.settings.sleeping = scene.sleeping;
  value.settings.islands_wait = scene.islands_wait;
  for (const char* own : {"gravity_mps2", "seed"}) {
    if (fields.contains(own))
      raise(bad_input(std::string(own) + ": the scene says it, and SceneRun(seed=...) the seed"));
  }
  py::object settings = py::cast(value);
  set_fields(settings, fields, "SceneRun");
  value = settings.cast<SettingsValue>();
  check_policy(value.policy);
  return value;
}

std::unique_ptr<SceneValue> make(const py::object& scene, const py::object& bodies, const py::object& seed,
                                 const py::object& tree_cache, const py::kwargs& fields) {
  auto value = std::make_unique<SceneValue>();
  const py::object path = py::module_::import("poise._scenes").attr("scene_path")(scene);
  value->scene = taken(read_scene(path_of(path)));
  check(read_gaze(value->scene));
  const SettingsValue settings = settings_of(value->scene, fields);
  SceneRunOptions options;
  options.world = settings.settings;
  // The functions of Python are put in when the World is there.
  options.world.policy = value->scene.policy;
  options.bodies = optional_whole("bodies", bodies);
  options.seed = optional_whole("seed", seed);
  options.tree_cache = tree_cache_of(tree_cache);
  if (options.bodies && value->scene.generators.empty())
    raise(bad_input("bodies: the scene " + value->scene.name + " has no generators"));
  value->run = loaded(value->scene, options);
  value->world = std::make_shared<WorldValue>(value->run, value->run->world(), settings.policy);
  return value;
}

ReportValue step_scene(SceneValue& value, const py::object& budget, const py::object& view, bool reference,
                       bool persist_events) {
  StepInput input;
  BudgetValue limit = budget_of(budget);
  if (budget.is_none())
    limit = BudgetValue::within(
        nanoseconds_of("deadline", value.scene.deadline_ms.value_or(1000 * value.scene.dt_s) / 1000));
  value.world->use();
  check(value.run->before_frame(value.frame));
  input.dt_s = value.scene.dt_s;
  input.view = view.is_none() ? value.run->view() : typed<View>("view", view, "a poise.View or None");
  input.max_level = value.scene.max_level;
  input.polygons = value.scene.polygons;
  input.backtracking = value.scene.backtracking;
  input.measure_energy = true;
  input.reference = reference;
  input.persist_events = persist_events;
  ReportValue report{value.world->step(input, limit), 0, true};
  report.time_s = static_cast<double>(++value.frame) * value.scene.dt_s;
  return report;
}

py::list run_frames(SceneValue& value, const py::object& frames, const py::object& budget, const py::object& each) {
  const std::uint64_t count = frames.is_none() ? value.scene.frames : whole_of("frames", frames, kMaxSceneFrames);
  py::list reports;
  for (std::uint64_t i = 0; i < count; ++i) {
    py::object report = py::cast(step_scene(value, budget, py::none(), false, false));
    reports.append(report);
    if (!each.is_none()) each(report);
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
  return reports;
}

py::list bodies_of(const SceneValue& value) {
  value.world->use();
  py::list bodies;
  for (const RunBody& body : value.run->bodies()) bodies.append(body);
  return bodies;
}

void bind_reading(py::class_<SceneValue>& bound) {
  bound
      .def_property_readonly(
          "world", [](const SceneValue& s) { return s.world; },
          "The World of the scene. Stepping it by itself leaves out the scene's streams and camera.")
      .def_property_readonly(
          "name", [](const SceneValue& s) { return s.scene.name; }, "Name of the scene.")
      .def_property_readonly(
          "dt_s", [](const SceneValue& s) { return s.scene.dt_s; }, "Length of a step, seconds.")
      .def_property_readonly(
          "frames", [](const SceneValue& s) { return s.scene.frames; }, "How many frames the scene asks for.")
      .def_property_readonly(
          "frame", [](const SceneValue& s) { return s.frame; }, "Number of frames done.")
      .def_property_readonly(
          "deadline_s", [](const SceneValue& s) { return s.scene.deadline_ms.value_or(1000 * s.scene.dt_s) / 1000; },
          "Deadline of a frame: the scene's, else its time step; seconds.")
      .def_property_readonly(
          "view",
          [](const SceneValue& s) -> std::optional<View> {
            if (!s.run->view().present) return std::nullopt;
            return s.run->view();
          },
          "The scene's camera and gaze at the start of the last frame, or None.")
      .def_property_readonly(
          "warnings",
          [](const SceneValue& s) {
            py::list lines;
            for (const std::string& line : s.run->warnings()) lines.append(line);
            return lines;
          },
          "Uncertain properties of the shapes, one line each.")
      .def("bodies", &bodies_of, "SceneBody of each body that is there now, in the order of the scene.");
}

}  // namespace

std::shared_ptr<SceneRun> loaded(const Scene& scene, const SceneRunOptions& options) {
  Result<SceneRun> run = [&] {
    const WithoutLock others;
    return SceneRun::create(scene, options);
  }();
  return std::make_shared<SceneRun>(taken(std::move(run)));
}

void bind_scene(py::module_& module) {
  py::class_<RunBody>(module, "SceneBody", "One body of a running scene.")
      .def_readonly("id", &RunBody::id, "BodyId.")
      .def_readonly("number", &RunBody::number, "From 0 in scene order; never given twice.")
      .def_property_readonly(
          "motion",
          [](const RunBody& b) {
            return b.motion == MotionType::Static      ? "static"
                   : b.motion == MotionType::Kinematic ? "kinematic"
                                                       : "dynamic";
          },
          "'static', 'kinematic' or 'dynamic'.");
  py::class_<SceneValue> bound(module, "SceneRun", R"(A scene file that runs, as `poise run` does.

SceneRun(scene, bodies=None, seed=None, tree_cache=None, **settings): scene is a path, or the name of a scene
that ships (poise.shipped_scenes()). bodies: how many all generators make together. tree_cache: as in
Shape.mesh. The settings are those of Settings but gravity_mps2 and seed; what is not given is as the scene
says, so the same frames with the same counted work have the state hash of `poise run SCENE --clock work
--budget-work N`. Not done here: the drawing load that a scene may ask for, and pacing. A scene that is refused
raises poise.Error with file, field, value and rule.)");
  bound
      .def(py::init(&make), py::arg("scene"), py::kw_only(), py::arg("bodies") = py::none(),
           py::arg("seed") = py::none(), py::arg("tree_cache") = py::none())
      .def("step", &step_scene, py::arg("budget") = py::none(), py::kw_only(), py::arg("view") = py::none(),
           py::arg("reference") = false, py::arg("persist_events") = false,
           R"(The next frame: bodies of streams come and leave, then the World steps. Returns a FrameReport.

budget: None is the scene's deadline. view: None is the scene's camera. reference, persist_events: as in
World.step.)")
      .def(
          "run", &run_frames, py::arg("frames") = py::none(), py::arg("budget") = py::none(), py::kw_only(),
          py::arg("each") = py::none(),
          "Many frames (None: as many as the scene asks for); returns their FrameReports. each(report) is called after "
          "each. Ctrl-C ends it between frames.");
  bind_reading(bound);
}

}  // namespace poise::python
