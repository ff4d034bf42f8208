// SPDX-License-Identifier: MIT
#include "step_values.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "scene/run/run_tables.h"

namespace poise::python {
namespace {

// What only a run from a file has.
constexpr std::array<std::string_view, 2> kOfRuns{"warm_up", "releases_skipped"};

std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells;
  while (!line.empty() && line.back() == '\n') line.remove_suffix(1);
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t end = std::min(line.find(',', from), line.size());
    cells.emplace_back(line.substr(from, end - from));
    from = end + 1;
  }
  return cells;
}

bool is_of_runs(std::string_view name) { return std::ranges::find(kOfRuns, name) != kOfRuns.end(); }

/// Whether a column has reals: by its unit, so that a whole number of milliseconds is a float too.
bool is_real(std::string_view name) {
  constexpr std::array<std::string_view, 9> kUnits{"_ms",  "_s",  "_j",  "_mps",      "_kgmps",
                                                   "_rel", "_mm", "_px", "cut_margin"};
  return std::ranges::any_of(kUnits, [name](std::string_view unit) { return name.ends_with(unit); });
}

py::object cell_of(std::string_view name, const std::string& cell) {
  if (cell.empty()) return py::none();
  if (name == "status" || name == "cause") return py::str(cell);
  if (is_real(name)) return py::float_(py::str(cell));
  return py::int_(py::str(cell));
}

Vec3 direction_of(const char* name, const Vec3& v) {
  const double length = v.norm();
  if (std::isfinite(length) && length > 0) return v / length;
  raise(bad_input(std::string(name) + " = " + py::repr(tuple_of(v)).cast<std::string>() +
                  ", must be finite and have a direction"));
}

double in_range(const char* name, double value, double least, double most) {
  if (value > least && value < most) return value;
  raise(bad_input(std::string(name) + " = " + py::repr(py::float_(value)).cast<std::string>() + ", must be in (" +
                  py::repr(py::float_(least)).cast<std::string>() + ", " +
                  py::repr(py::float_(most)).cast<std::string>() + ")"));
}

View make_view(const VectorArgument& position_m, const VectorArgument& look_at_m, const VectorArgument& up,
               double vertical_fov_rad, double aspect, const py::object& gaze_at_m) {
  View view;
  view.present = true;
  view.position_m = vec3_of("position_m", position_m);
  if (!view.position_m.allFinite())
    raise(bad_input("position_m = " + py::repr(tuple_of(view.position_m)).cast<std::string>() + ", must be finite"));
  view.forward = direction_of("look_at_m - position_m", vec3_of("look_at_m", look_at_m) - view.position_m);
  const Vec3 upward = direction_of("up", vec3_of("up", up));
  if (upward.cross(view.forward).norm() < 1e-3)
    raise(bad_input("up = " + py::repr(tuple_of(upward)).cast<std::string>() + ", must not be parallel to the view"));
  view.up = direction_of("up", upward - upward.dot(view.forward) * view.forward);
  view.vertical_fov_rad = in_range("vertical_fov_rad", vertical_fov_rad, 0, 3.14159);
  view.aspect = in_range("aspect", aspect, 0, 1e6);
  view.gaze = view.forward;
  if (!gaze_at_m.is_none())
    view.gaze = direction_of("gaze_at_m - position_m", vec3_of("gaze_at_m", {gaze_at_m}) - view.position_m);
  return view;
}

void bind_budget(py::module_& module) {
  py::class_<BudgetValue>(module, "Budget", R"(Limit of the work of a step beyond what every step must do.

Without a budget a step refines everything. A Budget may be used for any number of steps.)")
      .def_static(
          "unlimited", [] { return BudgetValue{}; }, "No limit.")
      .def_static(
          "work",
          [](const py::object& units) {
            return BudgetValue{.kind = Budget::Kind::Work, .work_units = whole_of("units", units, ~std::uint64_t{0})};
          },
          py::arg("units"),
          "At most so many node-pair expansions of refinement. The result is the same on every machine and any number "
          "of "
          "threads.")
      .def_static(
          "within", [](double seconds) { return BudgetValue::within(nanoseconds_of("seconds", seconds)); },
          py::arg("seconds"),
          "The step should return within this time from its start, seconds. 0 or less: only what it must do.")
      .def_static(
          "until",
          [](double time) {
            return BudgetValue{.kind = Budget::Kind::Deadline,
                               .deadline = SteadyClock::time_point(nanoseconds_of("time", time))};
          },
          py::arg("time"), "The step should return by this time of time.monotonic(), seconds.")
      .def("__repr__", [](const BudgetValue& b) -> std::string {
        const auto seconds = [](Nanoseconds time) {
          return py::repr(py::float_(seconds_of(time))).cast<std::string>();
        };
        if (b.kind == Budget::Kind::Work) return "poise.Budget.work(" + std::to_string(b.work_units) + ")";
        if (b.kind == Budget::Kind::Unlimited) return "poise.Budget.unlimited()";
        return b.from_start ? "poise.Budget.within(" + seconds(b.span) + ")"
                            : "poise.Budget.until(" + seconds(b.deadline.time_since_epoch()) + ")";
      });
}

void bind_view(py::module_& module) {
  py::class_<View>(module, "View",
                   R"(The viewer's camera and gaze. They affect the order of refinement and nothing else.

View(position_m, look_at_m, up=(0, 0, 1), vertical_fov_rad=0.87, aspect=16/9, gaze_at_m=None): a camera that
looks from one point at another (metres, world frame), with the gaze at a third one, or straight ahead. up need
not be perpendicular.)")
      .def(py::init(&make_view), py::arg("position_m"), py::arg("look_at_m"),
           py::arg("up") = py::make_tuple(0.0, 0.0, 1.0), py::arg("vertical_fov_rad") = 0.87,
           py::arg("aspect") = 16.0 / 9.0, py::arg("gaze_at_m") = py::none())
      .def(
          "gazing_at",
          [](const View& view, const VectorArgument& point_m) {
            View turned = view;
            turned.gaze = direction_of("point_m - position_m", vec3_of("point_m", point_m) - view.position_m);
            return turned;
          },
          py::arg("point_m"), "The same camera with the gaze at this point (metres, world frame).")
      .def_property_readonly(
          "position_m", [](const View& v) { return tuple_of(v.position_m); }, "Metres, world frame.")
      .def_property_readonly(
          "forward", [](const View& v) { return tuple_of(v.forward); }, "Unit, world frame.")
      .def_property_readonly(
          "up", [](const View& v) { return tuple_of(v.up); }, "Unit, world frame.")
      .def_property_readonly(
          "gaze", [](const View& v) { return tuple_of(v.gaze); }, "Unit direction of the gaze.")
      .def_readonly("vertical_fov_rad", &View::vertical_fov_rad, "Radians.")
      .def_readonly("aspect", &View::aspect, "Width / height.");
}

}  // namespace

Budget BudgetValue::resolved() const {
  switch (kind) {
    case Budget::Kind::Work:
      return Budget::work(work_units);
    case Budget::Kind::Deadline:
      return from_start ? Budget::within(span) : Budget::until(deadline);
    case Budget::Kind::Unlimited:
      break;
  }
  return Budget::unlimited();
}

const std::vector<std::string>& report_columns() {
  static const std::vector<std::string> columns = [] {
    std::vector<std::string> names = cells_of(io::frames_header());
    std::erase_if(names, [](const std::string& name) { return is_of_runs(name); });
    return names;
  }();
  return columns;
}

py::dict columns_of(ReportValue& value) {
  if (!value.columns.is_none()) return value.columns.cast<py::dict>();
  static const std::vector<std::string> names = cells_of(io::frames_header());
  simulation::RunFrame frame;
  frame.report = value.report;
  std::string row;
  io::append_frame(frame, value.time_s, row);
  const std::vector<std::string> cells = cells_of(row);
  py::dict columns;
  for (std::size_t i = 0; i < names.size() && i < cells.size(); ++i) {
    if (is_of_runs(names[i])) continue;
    const bool unknown = names[i] == "time_s" && !value.has_time;
    columns[py::str(names[i])] = unknown ? py::object(py::none()) : cell_of(names[i], cells[i]);
  }
  value.columns = columns;
  return columns;
}

void bind_step_values(py::module_& module) {
  bind_budget(module);
  bind_view(module);
  py::class_<ReportValue> report(
      module, "FrameReport",
      R"(What a step did and how long it took: an attribute for each column of `poise run --frames-csv`.

Times end in _ms and are milliseconds; counts are ints; `status` and `cause` are words; what a step did not
measure is None. Most used: total_ms, refine_ms, lateness_ms (past the deadline; 0 on time), miss (0 or 1),
cause (none, infeasible, machine, overrun, forecast or release), bodies, contact_pairs, level_0 to level_6 and
polygons (contact pairs by completed level), work_refine (node-pair expansions), pairs_left, kinetic_j and
potential_j (with measure_energy). docs/run-report.md and the header poise/step.h say what each one means.
as_dict() has them all.)");
  for (const std::string& name : report_columns()) {
    report.def_property_readonly(
        name.c_str(), [name](ReportValue& value) { return py::object(columns_of(value)[py::str(name)]); },
        ("Column " + name + " of --frames-csv.").c_str());
  }
  report
      .def(
          "as_dict", [](ReportValue& value) { return columns_of(value).attr("copy")(); },
          "All columns, by name, in the order of --frames-csv.")
      .def("__repr__", [](const ReportValue& value) {
        return "<poise.FrameReport frame " + std::to_string(value.report.frame) + ", " +
               std::to_string(value.report.contact_pairs) + " contact pairs>";
      });
}

}  // namespace poise::python
