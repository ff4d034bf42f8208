// SPDX-License-Identifier: MIT
#include <cstdint>
#include <string>
#include <vector>

#include "arrays.h"
#include "world_value.h"

namespace poise::python {
namespace {

/// A row of contacts().
struct ContactRow {
  std::uint32_t a, b;
  std::uint32_t level, point_count;
  double normal[3], point_m[3];
  double gap_m;
  double impulse_ns[3];
};
/// A row of contact_points().
struct PointRow {
  std::uint32_t contact, a, b, level;
  double point_m[3], normal[3];
  double separation_m;
  double impulse_ns[3];
};

void copy(const Vec3& from, double (&to)[3]) {
  for (std::size_t k = 0; k < 3; ++k) to[k] = from[static_cast<Eigen::Index>(k)];
}

py::array contacts(WorldValue& world) {
  std::vector<ContactRow> rows;
  for (const Contact& contact : world.use().contacts()) {
    ContactRow& row = rows.emplace_back();
    row.a = contact.a.slot;
    row.b = contact.b.slot;
    row.level = contact.level;
    row.point_count = contact.point_count;
    row.gap_m = contact.gap_m;
    copy(contact.normal, row.normal);
    copy(contact.point_m, row.point_m);
    copy(contact.impulse_ns, row.impulse_ns);
  }
  const auto count = static_cast<py::ssize_t>(rows.size());
  return owned(std::move(rows), {count});
}

py::array contact_points(WorldValue& world) {
  std::vector<PointRow> rows;
  std::uint32_t number = 0;
  for (const Contact& contact : world.use().contacts()) {
    for (const ContactPoint& point : contact.points()) {
      PointRow& row = rows.emplace_back();
      row.contact = number;
      row.a = contact.a.slot;
      row.b = contact.b.slot;
      row.level = contact.level;
      row.separation_m = point.separation_m;
      copy(point.point_m, row.point_m);
      copy(point.normal, row.normal);
      copy(point.impulse_ns, row.impulse_ns);
    }
    ++number;
  }
  const auto count = static_cast<py::ssize_t>(rows.size());
  return owned(std::move(rows), {count});
}

const char* event_kind(const ContactEvent& event) {
  switch (event.kind) {
    case ContactEvent::Kind::Begin:
      return "begin";
    case ContactEvent::Kind::End:
      return "end";
    case ContactEvent::Kind::Persist:
      break;
  }
  return "persist";
}

/// A column of states: `columns` numbers a row, 0 for a plain row of numbers.
template <class T>
void bind_column(py::class_<StateRows, std::shared_ptr<StateRows>>& bound, const char* name,
                 std::vector<T> StateRows::*member, py::ssize_t columns, const char* doc) {
  bound.def_property_readonly(
      name,
      [member, columns](const py::object& self) {
        const auto& rows = self.cast<const StateRows&>();
        std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(rows.bodies.size())};
        if (columns > 0) shape.push_back(columns);
        return shown((rows.*member).data(), shape, self);
      },
      doc);
}

void bind_states(py::module_& module) {
  py::class_<StateRows, std::shared_ptr<StateRows>> bound(
      module, "States",
      R"(States of all bodies as arrays of NumPy, one row a body, in order of slots: the result of World.states().

The arrays show the memory of this object without a copy and cannot be written through. They stay readable as
long as you keep them, also when the World is gone. The next call of World.states() fills the same memory again
if the World still has the same bodies, so all arrays then show the newer state; if bodies came or left, it
makes new memory and these arrays stay as they are. A step alone changes nothing in them. Take a copy
(`.copy()`) of what must not change.)");
  bind_column(bound, "position_m", &StateRows::position_m, 3, "(n, 3) float64: centres of mass, world frame, metres.");
  bind_column(bound, "orientation_wxyz", &StateRows::orientation_wxyz, 4,
              "(n, 4) float64: unit quaternions, w first, body to world.");
  bind_column(bound, "velocity_mps", &StateRows::velocity_mps, 3, "(n, 3) float64: of the centres of mass, m/s.");
  bind_column(bound, "angular_velocity_radps", &StateRows::angular_velocity_radps, 3,
              "(n, 3) float64: world frame, rad/s.");
  bind_column(bound, "slot", &StateRows::slot, 0,
              "(n,) uint32: BodyId.slot of each row, ascending: numpy.searchsorted finds the rows of slots.");
  bind_column(bound, "generation", &StateRows::generation, 0, "(n,) uint32: BodyId.generation of each row.");
  bound.def("__len__", [](const StateRows& rows) { return rows.bodies.size(); });
}

void bind_result_values(py::module_& module) {
  py::class_<ContactEvent>(module, "ContactEvent", "A pair that began or ceased to touch in the last step.")
      .def_property_readonly("kind", &event_kind, "'begin', 'end', or with persist_events 'persist'.")
      .def_readonly("a", &ContactEvent::a, "BodyId; in an 'end' it may be stale.")
      .def_readonly("b", &ContactEvent::b, "BodyId; after a in the order of slots.")
      .def_property_readonly(
          "impulse_ns", [](const ContactEvent& e) { return tuple_of(e.impulse_ns); },
          "Received by b in the step, kg m/s; 0 at the end.")
      .def("__repr__", [](const ContactEvent& e) {
        return std::string("<poise.ContactEvent ") + event_kind(e) + " of slots " + std::to_string(e.a.slot) + " and " +
               std::to_string(e.b.slot) + ">";
      });
  py::class_<Conserved>(module, "Conserved", "Sums over the dynamic bodies.")
      .def_property_readonly(
          "momentum_ns", [](const Conserved& c) { return tuple_of(c.momentum_ns); }, "kg m/s.")
      .def_property_readonly(
          "angular_momentum_js", [](const Conserved& c) { return tuple_of(c.angular_momentum_js); },
          "About the world origin, kg m^2/s.")
      .def_readonly("kinetic_j", &Conserved::kinetic_j, "Kinetic energy, joules.")
      .def_readonly("potential_j", &Conserved::potential_j, "-m g . x, joules, 0 at the world origin.");
}

}  // namespace

void bind_results(py::module_& module, WorldClass& world) {
  PYBIND11_NUMPY_DTYPE(ContactRow, a, b, level, point_count, normal, point_m, gap_m, impulse_ns);
  PYBIND11_NUMPY_DTYPE(PointRow, contact, a, b, level, point_m, normal, separation_m, impulse_ns);
  bind_states(module);
  bind_result_values(module);
  world
      .def(
          "states", &WorldValue::states,
          "States of all bodies now, as arrays (States says how long they are valid). Takes time linear in the bodies.")
      .def("contacts", &contacts,
           R"(The pairs that touched in the last step: a structured array, a copy, in the order of (a, b).

Fields: a, b (slots of the bodies), level (completed for the pair), point_count (1 to 8), normal (3, unit, from
a to b), point_m (3, metres, world frame), gap_m (separation of the modelled surfaces at the start of the step,
negative in overlap), impulse_ns (3, kg m/s, received by b). The first call after a step makes the list; it
costs nothing if unused.)")
      .def("contact_points", &contact_points,
           R"(The points of the manifolds of contacts(): a structured array, a copy, up to eight rows a contact.

Fields: contact (row of contacts()), a, b (slots), level, point_m (3), normal (3), separation_m, impulse_ns (3).)")
      .def(
          "contact_events",
          [](WorldValue& w) {
            py::list events;
            for (const ContactEvent& event : w.use().contact_events()) events.append(event);
            return events;
          },
          "ContactEvents of the last step, in the order of (a, b).")
      .def(
          "conserved", [](WorldValue& w) { return w.use().conserved(); },
          "Momentum, angular momentum and energy of the dynamic bodies.");
}

}  // namespace poise::python
