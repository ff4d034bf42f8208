// SPDX-License-Identifier: MIT
#include "world_step.h"

#include <optional>
#include <string>

namespace poise::python {
namespace {

ReportValue step_world(WorldValue& world, const py::object& budget, double dt_s, const py::object& view,
                       const py::object& attend_center_m, double attend_radius_m, const py::object& attend_body,
                       const py::object& host_work_s, const py::object& max_level, bool polygons, bool backtracking,
                       bool reference, bool measure_energy, bool persist_events) {
  StepInput input;
  input.dt_s = dt_s;
  if (!view.is_none()) input.view = typed<View>("view", view, "a poise.View or None");
  if (!attend_center_m.is_none()) {
    input.attention.center_m = vec3_of("attend_center_m", {attend_center_m});
    input.attention.radius_m = attend_radius_m;
  }
  if (!attend_body.is_none())
    input.attention.body = typed<BodyId>("attend_body", attend_body, "a poise.BodyId or None");
  if (py::isinstance<py::str>(host_work_s)) {
    if (host_work_s.cast<std::string>() != "learn")
      raise(bad_input("host_work_s = " + host_work_s.cast<std::string>() + ", must be 'learn' or seconds"));
    input.host_work.learn = true;
  } else {
    input.host_work.expected =
        nanoseconds_of("host_work_s", typed<double>("host_work_s", host_work_s, "seconds or 'learn'"));
  }
  input.max_level = static_cast<Level>(whole_of("max_level", max_level, kMaxTreeDepth));
  input.polygons = polygons;
  input.backtracking = backtracking;
  input.reference = reference;
  input.measure_energy = measure_energy;
  input.persist_events = persist_events;
  return {world.step(input, budget_of(budget)), 0, false};
}

}  // namespace

BudgetValue budget_of(const py::object& given) {
  if (given.is_none()) return {};
  if (py::isinstance<BudgetValue>(given)) return given.cast<BudgetValue>();
  throw py::type_error("budget must be a poise.Budget or None, not " + py::repr(given).cast<std::string>() +
                       "; poise.Budget.within(seconds), .until(time) or .work(units) make one");
}

void bind_step(WorldClass& world) {
  world
      .def("step", &step_world, py::arg("budget") = py::none(), py::kw_only(), py::arg("dt_s") = 1.0 / 60.0,
           py::arg("view") = py::none(), py::arg("attend_center_m") = py::none(), py::arg("attend_radius_m") = 0.0,
           py::arg("attend_body") = py::none(), py::arg("host_work_s") = 0.0, py::arg("max_level") = kMaxTreeDepth,
           py::arg("polygons") = false, py::arg("backtracking") = false, py::arg("reference") = false,
           py::arg("measure_energy") = false, py::arg("persist_events") = false,
           R"(Steps once and returns a FrameReport. Other Python threads run meanwhile: the global lock is released.

budget: a Budget, or None for all refinement. dt_s: length of the step, seconds, at most 1000. view: the viewer
(View). attend_center_m, attend_radius_m, attend_body: a ball (metres) and a body that matter now, with the
policy's weight `attention`. host_work_s: seconds of your own work that must still run before the deadline, or
'learn' to go by report_host_work. max_level: no deeper than this level of the trees. polygons: one more level,
the triangles of meshes. backtracking: continuous collision of fast bodies. reference: compute the step again at
full depth and fill the columns reference_* (slow). measure_energy: fill kinetic_j, potential_j, momentum_*.
persist_events: contact_events() lists pairs that go on touching too.

With other Python threads at work, a step that ends on time may still wait for the global lock, up to
sys.getswitchinterval(): that time is in no figure of the report.)")
      .def(
          "report_host_work",
          [](WorldValue& w, double seconds) { w.use().report_host_work(nanoseconds_of("seconds", seconds)); },
          py::arg("seconds"),
          "Tells how long your own work of the frame that has just ended took, for host_work_s='learn'.")
      .def_property_readonly("settings", &WorldValue::settings,
                             "The present settings, a copy (set_settings changes them).")
      .def(
          "set_settings",
          [](WorldValue& w, const py::kwargs& fields) {
            py::object now = py::cast(w.settings());
            set_fields(now, fields, "Settings");
            w.set_settings(now.cast<SettingsValue>());
          },
          "set_settings(**fields): changes the named settings for the next steps, e.g. policy, gravity_mps2, alpha. "
          "What "
          "is fixed at creation (executor, threads, spin_s, processors, realtime_priority, max_front_entries) is "
          "refused.")
      .def("set_pair_filter", &WorldValue::set_filter, py::arg("function"),
           R"(A function (BodyId a, BodyId b, int user_data_a, int user_data_b) -> bool, or None.

Pairs for which it returns False pass through each other. It is called for each candidate pair of each step,
with the global lock: slow, as a cue in Python is. It must not use the World, and must give the same for the
same pair.)")
      .def_property_readonly(
          "threads", [](WorldValue& w) { return w.use().threads(); },
          "Threads that may work on a step, the calling one included.")
      .def(
          "state_hash",
          [](WorldValue& w) {
            std::string digits(16, '0');
            std::uint64_t hash = w.use().state_hash();
            for (std::size_t i = 16; i-- > 0; hash >>= 4U) digits[i] = "0123456789abcdef"[hash & 15U];
            return digits;
          },
          "Hash of all that the next step depends on, 16 hexadecimal digits, as `poise run` prints it.");
}

}  // namespace poise::python
