// SPDX-License-Identifier: MIT
#include "host_functions.h"

#include <array>
#include <span>
#include <utility>

namespace poise::python {
namespace {

using scheduler::FrameFacts;
using scheduler::PairChain;
using scheduler::PairCues;
using scheduler::PairView;

/// Calls a function of the host and gives what it returned as a number. After a failure nothing is called until the
/// step has ended and raised it.
template <class... Arguments>
double number_of(HostFunctions& host, const py::object& function, double otherwise, Arguments&&... arguments) noexcept {
  try {
    if (host.failure) return otherwise;
    const py::object returned = function(std::forward<Arguments>(arguments)...);
    const double number = PyFloat_AsDouble(returned.ptr());
    if (number == -1.0 && PyErr_Occurred() != nullptr) throw py::error_already_set();
    return number;
  } catch (...) {
    host.failure = std::current_exception();
    return otherwise;
  }
}

double call_cue(const PairView& view, void* context) noexcept {
  const py::gil_scoped_acquire lock;
  auto& host = *static_cast<HostFunctions*>(context);
  return number_of(host, host.cue, 1, view);
}

py::tuple tuple_of_span(std::span<const float> numbers) {
  py::tuple out(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) out[i] = py::float_(static_cast<double>(numbers[i]));
  return out;
}

double call_policy(const FrameFacts& frame, const PairChain& chain, const PairCues& cues, void* context) noexcept {
  const py::gil_scoped_acquire lock;
  auto& host = *static_cast<HostFunctions*>(context);
  const ChainFacts facts{chain, tuple_of_span(chain.error_m), tuple_of_span(chain.lifetime_frames),
                         tuple_of_span(chain.ended)};
  return number_of(host, host.policy, 0, frame, facts, cues);
}

void bind_views(py::module_& module) {
  py::class_<PairView>(module, "PairView", R"(A viewer's view of a pair of bodies: the argument of a cue.

Lengths in metres, world frame. Without a viewer the pair counts as in the frustum, gazed at and at distance 0.
The last six are 0 or False where the weight of their cue is 0, since then they are not measured.)")
      .def_readonly("pair_id", &PairView::pair_id, "Identifies the pair across frames.")
      .def_property_readonly(
          "user_data", [](const PairView& v) { return py::make_tuple(v.user_data.a, v.user_data.b); },
          "The host's values of the two bodies (`user_data` of add_body), (int, int).")
      .def_property_readonly(
          "point_m", [](const PairView& v) { return py::make_tuple(v.point_m[0], v.point_m[1], v.point_m[2]); },
          "Contact point, or the expected one, metres.")
      .def_property_readonly(
          "normal", [](const PairView& v) { return py::make_tuple(v.normal[0], v.normal[1], v.normal[2]); },
          "Approximately unit, from one body to the other.")
      .def_readonly("extent_m", &PairView::extent_m, "Radius of the smaller body, metres.")
      .def_readonly("closing_mps", &PairView::closing_mps, "Approach speed of the two surfaces, m/s, >= 0.")
      .def_readonly("importance", &PairView::importance, "Product of what the scene gives to the two bodies.")
      .def_readonly("frames_waited", &PairView::frames_waited, "Frames since the pair was last refined.")
      .def_readonly("has_view", &PairView::has_view, "Whether there is a viewer.")
      .def_readonly("in_frustum", &PairView::in_frustum, "Whether the viewer's camera sees the point.")
      .def_readonly("distance_m", &PairView::distance_m, "From the eye, metres.")
      .def_readonly("angle_radpm", &PairView::angle_radpm, "Visible angle of one metre of error, rad/m.")
      .def_readonly("eccentricity_rad", &PairView::eccentricity_rad, "Angle between gaze and pair, radians in [0, pi].")
      .def_readonly("gap_rad", &PairView::gap_rad, "Visible angle of the gap or penetration, radians.")
      .def_readonly("delay_s", &PairView::delay_s, "For how long approaching surfaces were not refined, seconds.")
      .def_readonly("age_s", &PairView::age_s, "Since the contact began, seconds.")
      .def_readonly("crowd", &PairView::crowd, "Other events near by on the screen.")
      .def_readonly("hidden", &PairView::hidden, "Whether all that moves of the pair is surely behind other bodies.")
      .def_readonly("attended", &PairView::attended, "Whether the attention of the step is on it.");
}

void bind_facts(py::module_& module) {
  py::class_<FrameFacts>(module, "FrameFacts", "Facts of a frame: the first argument of a policy in Python.")
      .def_readonly("frame", &FrameFacts::frame, "Number of steps done before.")
      .def_readonly("seed", &FrameFacts::seed, "Settings.seed.")
      .def_readonly("deepest_level", &FrameFacts::deepest_level,
                    "Over all pairs; >= 1 if there is something to refine.")
      .def_readonly("pairs", &FrameFacts::pairs, "Number of pairs that can be refined.");
  py::class_<ChainFacts>(
      module, "PairChain",
      "Cost and expected gain of refining a pair further: the second argument of a policy in Python.")
      .def_property_readonly(
          "pair_id", [](const ChainFacts& f) { return f.chain.pair_id; }, "Identifies the pair.")
      .def_property_readonly(
          "level", [](const ChainFacts& f) { return f.chain.level; }, "The completed level.")
      .def_readonly("error_m", &ChainFacts::error_m, "Expected error of each level from 0 to the deepest, metres.")
      .def_property_readonly(
          "front_entries", [](const ChainFacts& f) { return f.chain.front_entries; },
          "Cost of the next level, node-pair expansions (units of work).")
      .def_property_readonly(
          "user_data", [](const ChainFacts& f) { return py::make_tuple(f.chain.user_data.a, f.chain.user_data.b); },
          "The host's values of the two bodies, (int, int).")
      .def_property_readonly(
          "begun", [](const ChainFacts& f) { return f.chain.begun; },
          "Whether a level of it was completed in this frame.")
      .def_property_readonly(
          "last_level", [](const ChainFacts& f) { return f.chain.last_level; },
          "By which the pair was answered in the frame before.")
      .def_readonly("lifetime_frames", &ChainFacts::lifetime_frames,
                    "Of each level: for how many frames what it finds is valid; empty: 1.")
      .def_readonly("ended", &ChainFacts::ended,
                    "Of each level: probability that it or one before it finds the pair separated; may be empty.");
  py::class_<PairCues>(module, "PairCues",
                       "The cues of a pair, what a viewer can notice of it: the third argument of a policy in Python.")
      .def_readonly("visibility", &PairCues::visibility, "1 in the frustum, less outside it; in (0, 1].")
      .def_readonly("angle_radpm", &PairCues::angle_radpm, "Visible angle of one metre of error, rad/m.")
      .def_readonly("eccentricity_rad", &PairCues::eccentricity_rad, "Angle between gaze and pair, radians.")
      .def_readonly("closing_mps", &PairCues::closing_mps, "Approach speed of the two surfaces, m/s.")
      .def_readonly("frames_waited", &PairCues::frames_waited, "Frames since the pair was last refined.")
      .def_readonly("importance", &PairCues::importance, "Of the two bodies together, >= 0.")
      .def_readonly("host", &PairCues::host, "What the host's own cue returned.")
      .def_readonly("gap_rad", &PairCues::gap_rad, "Visible angle of the gap or penetration, radians.")
      .def_readonly("delay_s", &PairCues::delay_s, "For how long approaching surfaces were not refined, seconds.")
      .def_readonly("age_s", &PairCues::age_s, "Since the contact began, seconds.")
      .def_readonly("separation", &PairCues::separation, "Separation of the surfaces over its expected error.")
      .def_readonly("crowd", &PairCues::crowd, "Other events near by on the screen.")
      .def_readonly("hidden", &PairCues::hidden, "Whether it is surely behind other bodies.")
      .def_readonly("attended", &PairCues::attended, "Whether the attention of the step is on it.");
}

}  // namespace

void HostFunctions::attach(scheduler::Policy& to) {
  to.cue = {};
  to.custom = {};
  if (!cue.is_none()) to.cue = {call_cue, this};
  if (!policy.is_none()) to.custom = {call_policy, this};
}

void HostFunctions::rethrow() {
  if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
}

bool call_filter(void* context, const FilteredPair& pair) {
  const py::gil_scoped_acquire lock;
  auto& host = *static_cast<HostFunctions*>(context);
  try {
    if (host.failure) return true;
    const py::object returned = host.filter(pair.a, pair.b, pair.user_data_a, pair.user_data_b);
    const int truth = PyObject_IsTrue(returned.ptr());
    if (truth < 0) throw py::error_already_set();
    return truth != 0;
  } catch (...) {
    host.failure = std::current_exception();
    return true;
  }
}

void bind_host_functions(py::module_& module) {
  bind_views(module);
  bind_facts(module);
}

}  // namespace poise::python
