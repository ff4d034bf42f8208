// SPDX-License-Identifier: MIT
#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <pybind11/stl.h>

#include "parallel/executor.h"
#include "record/record_file.h"
#include "record/record_shapes.h"
#include "scene_value.h"

namespace poise::python {
namespace {

/// A record that is done again, frame by frame.
struct ReplayValue {
  explicit ReplayValue(io::RecordReader reader) : record(std::move(reader)) {}
  io::RecordReader record;
  std::string path;
  Scene scene;
  std::shared_ptr<SceneRun> run;
  std::shared_ptr<WorldValue> world;
  io::RecordedFrame recorded;
  std::uint64_t frames = 0;  ///< done, the one that differs too
  bool whole = false;        ///< its end was read
  std::optional<std::uint64_t> differs;
  std::optional<std::string> damage;
};

Scene scene_of(const ReplayValue& value, const py::object& files) {
  const io::RecordHeader& header = value.record.header();
  const std::filesystem::path folder = files.is_none() ? std::filesystem::path(header.scene_folder) : path_of(files);
  Scene scene = taken(parse_scene(header.scene_text, value.path + ": scene " + header.scene_source, folder));
  if (header.gaze) {
    if (!scene.camera) raise(bad_input(value.path + ": gaze: the recorded scene has no camera"));
    auto keys = taken(parse_gaze(*header.gaze, value.path + ": gaze", scene.camera->resolution_px));
    scene.gaze = SceneGaze{std::move(keys), true, header.gaze_loop, {}, *header.gaze};
  }
  check(io::check_files(scene, header.shapes));
  return scene;
}

/// The capacity for fronts is the total of the recorded threads, as `poise replay` takes it.
WorldSettings settings_of(const io::RecordHeader& header, int threads) {
  constexpr std::uint64_t kMostEntries = 1U << 26U;
  WorldSettings world = header.world;
  world.executor = SettingsValue().settings.executor;
  world.threads = threads;
  const auto before = static_cast<std::uint64_t>(header.world.threads);
  const auto now = static_cast<std::uint64_t>(threads > 0 ? threads : parallel::available_threads());
  const std::uint64_t shared = (header.world.max_front_entries * before + now - 1) / now;
  world.max_front_entries =
      static_cast<std::uint32_t>(std::clamp<std::uint64_t>(shared, header.world.max_front_entries, kMostEntries));
  // The levels are those of the record, whatever the policy.
  world.processors.clear();
  world.realtime_priority = 0;
  return world;
}

std::unique_ptr<ReplayValue> open_replay(const py::object& path, const py::object& files, const py::object& threads,
                                         const py::object& tree_cache) {
  const std::filesystem::path file = path_of(path);
  auto value = std::make_unique<ReplayValue>(taken(io::RecordReader::open(file)));
  value->path = file.string();
  value->scene = scene_of(*value, files);
  const io::RecordHeader& header = value->record.header();
  SceneRunOptions options;
  options.world = settings_of(header, static_cast<int>(whole_of("threads", threads, 256)));
  options.bodies = header.bodies;
  options.seed = header.seed;
  options.tree_cache = tree_cache_of(tree_cache);
  value->run = loaded(value->scene, options);
  check(io::check_shapes(value->scene, value->run->shapes(), header.shapes));
  value->world = std::make_shared<WorldValue>(value->run, value->run->world(), PolicyValue{header.world.policy});
  if (value->run->world().state_hash() != header.start_hash)
    raise(bad_input(value->path + ": the bodies stand otherwise at the start than when it was recorded"));
  return value;
}

/// The next frame; none at the end, after damage and after a difference.
std::optional<ReportValue> step_replay(ReplayValue& value) {
  value.world->use();
  if (value.whole || value.differs || value.damage) return std::nullopt;
  const io::RecordReader::Next next = value.record.next(value.recorded);
  if (next == io::RecordReader::Next::End) value.whole = true;
  if (next == io::RecordReader::Next::Damaged) value.damage = value.record.damage()->what;
  if (next != io::RecordReader::Next::Frame) return std::nullopt;
  check(value.run->before_frame(value.frames));
  const io::RecordHeader& header = value.record.header();
  StepInput input;
  input.dt_s = header.dt_s;
  input.max_level = header.max_level;
  input.polygons = header.polygons;
  input.backtracking = header.backtracking;
  input.measure_energy = true;
  input.view = value.run->view();
  input.replay = &value.recorded.decisions;
  ReportValue report{value.world->step(input, {}), 0, true};
  const bool same =
      report.report.status == StepStatus::Done && value.run->world().state_hash() == value.recorded.state_hash;
  if (!same) value.differs = value.frames;
  report.time_s = static_cast<double>(++value.frames) * header.dt_s;
  return report;
}

}  // namespace

void bind_replay(py::module_& module) {
  py::class_<ReplayValue>(module, "Replay", R"(A record of a run, done again bit for bit (docs/record.md).

Replay(path, files=None, threads=0, tree_cache=None): the record of `poise run --record`. files: folder of its
meshes and trees, None for where they were. Iterating steps: each frame gives a FrameReport, and `world` has its
state. It ends with the record, at damage, or after the first frame whose state is not that of the record:
`same`, `whole` and `damage` tell.)")
      .def(py::init(&open_replay), py::arg("path"), py::kw_only(), py::arg("files") = py::none(),
           py::arg("threads") = 0, py::arg("tree_cache") = py::none())
      .def("step", &step_replay, "The next frame: a FrameReport with the times of the replay, or None after the last.")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__",
           [](ReplayValue& value) {
             if (PyErr_CheckSignals() != 0) throw py::error_already_set();
             std::optional<ReportValue> report = step_replay(value);
             if (!report) throw py::stop_iteration();
             return *report;
           })
      .def_property_readonly(
          "world", [](const ReplayValue& v) { return v.world; }, "The World, to be read alone.")
      .def_property_readonly(
          "scene", [](const ReplayValue& v) { return v.record.header().scene_name; }, "Name of the scene.")
      .def_property_readonly(
          "clock", [](const ReplayValue& v) { return v.record.header().clock; },
          "'wall' or 'work': by which the run was limited.")
      .def_property_readonly(
          "deadline_s", [](const ReplayValue& v) { return v.record.header().deadline_ms / 1000; },
          "Deadline of a frame of the run, seconds; 0 with counted work.")
      .def_property_readonly(
          "frames", [](const ReplayValue& v) { return v.frames; }, "Number of frames done.")
      .def_property_readonly(
          "same", [](const ReplayValue& v) { return !v.differs; },
          "Whether the state was that of the record after every frame so far.")
      .def_property_readonly(
          "first_difference", [](const ReplayValue& v) { return v.differs; },
          "The first frame, from 0, whose state differs; or None.")
      .def_property_readonly(
          "whole", [](const ReplayValue& v) { return v.whole; },
          "Whether the end of the record was reached, undamaged.")
      .def_property_readonly(
          "damage", [](const ReplayValue& v) { return v.damage; },
          "What is wrong with the record where it can be read no further; or None.");
}

}  // namespace poise::python
