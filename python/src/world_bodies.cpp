// SPDX-License-Identifier: MIT
#include <array>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "arrays.h"
#include "world_value.h"

namespace poise::python {
namespace {

constexpr std::array<std::string_view, 3> kMotions{"static", "kinematic", "dynamic"};
constexpr std::uint64_t kMostBits = 0xffffffffU;

/// What bodies of a call have in common.
BodyDefinition definition_of(WorldValue& world, const ShapeValue& shape, MaterialId material, const std::string& motion,
                             double mass_kg, const VectorArgument& inertia_kgm2, const py::object& group,
                             const py::object& collides_with, double importance) {
  BodyDefinition definition;
  definition.motion = static_cast<MotionType>(index_of("motion", motion, kMotions));
  definition.mass_kg = mass_kg;
  definition.inertia_kgm2 = vec3_of("inertia_kgm2", inertia_kgm2);
  definition.group = static_cast<std::uint32_t>(whole_of("group", group, kMostBits));
  definition.collides_with = static_cast<std::uint32_t>(whole_of("collides_with", collides_with, kMostBits));
  definition.importance = importance;
  definition.material = material;
  definition.shape = world.id_of(shape);
  return definition;
}

BodyId add_body(WorldValue& world, const ShapeValue& shape, MaterialId material, const std::string& motion,
                const VectorArgument& position_m, const QuaternionArgument& orientation_wxyz,
                const VectorArgument& velocity_mps, const VectorArgument& angular_velocity_radps, double mass_kg,
                const VectorArgument& inertia_kgm2, const py::object& group, const py::object& collides_with,
                double importance, const py::object& user_data) {
  BodyDefinition definition =
      definition_of(world, shape, material, motion, mass_kg, inertia_kgm2, group, collides_with, importance);
  definition.position_m = vec3_of("position_m", position_m);
  definition.orientation = quat_of("orientation_wxyz", orientation_wxyz);
  definition.velocity_mps = vec3_of("velocity_mps", velocity_mps);
  definition.angular_velocity_radps = vec3_of("angular_velocity_radps", angular_velocity_radps);
  definition.user_data = whole_of("user_data", user_data, ~std::uint64_t{0});
  return taken(world.use().add_body(definition));
}

/// A column of add_bodies: empty where it was not given.
template <class T>
struct Column {
  std::optional<py::array_t<T, py::array::c_style | py::array::forcecast>> rows;

  Column(const char* name, const py::object& given, py::ssize_t columns, py::ssize_t count) {
    if (given.is_none()) return;
    rows = rows_of<T>(name, given, columns);
    if (rows->shape(0) != count)
      raise(bad_input(std::string(name) + ", must have as many rows (" + std::to_string(rows->shape(0)) +
                      ") as position_m (" + std::to_string(count) + ")"));
  }
};

py::list add_bodies(WorldValue& world, const ShapeValue& shape, MaterialId material, const py::object& position_m,
                    const py::object& orientation_wxyz, const py::object& velocity_mps,
                    const py::object& angular_velocity_radps, const py::object& user_data, const std::string& motion,
                    double mass_kg, const VectorArgument& inertia_kgm2, const py::object& group,
                    const py::object& collides_with, double importance) {
  BodyDefinition definition =
      definition_of(world, shape, material, motion, mass_kg, inertia_kgm2, group, collides_with, importance);
  const auto positions = rows_of<double>("position_m", position_m, 3);
  const py::ssize_t count = positions.shape(0);
  const Column<double> orientations("orientation_wxyz", orientation_wxyz, 4, count);
  const Column<double> velocities("velocity_mps", velocity_mps, 3, count);
  const Column<double> spins("angular_velocity_radps", angular_velocity_radps, 3, count);
  const Column<std::int64_t> values("user_data", user_data, 1, count);
  const auto go_to_row = [&](py::ssize_t i) {
    definition.position_m = {positions.at(i, 0), positions.at(i, 1), positions.at(i, 2)};
    if (const auto& o = orientations.rows)
      definition.orientation = {o->at(i, 0), o->at(i, 1), o->at(i, 2), o->at(i, 3)};
    if (const auto& v = velocities.rows) definition.velocity_mps = {v->at(i, 0), v->at(i, 1), v->at(i, 2)};
    if (const auto& w = spins.rows) definition.angular_velocity_radps = {w->at(i, 0), w->at(i, 1), w->at(i, 2)};
    if (values.rows) definition.user_data = static_cast<std::uint64_t>(values.rows->at(i));
  };
  // All are looked at before the first is added: a body that is taken away again leaves another state behind.
  for (py::ssize_t i = 0; i < count; ++i) {
    go_to_row(i);
    const Status sound = !values.rows || values.rows->at(i) >= 0
                             ? world.use().check_body(definition)
                             : bad_input("user_data = " + std::to_string(values.rows->at(i)) + ", must be >= 0");
    if (!sound) raise({sound.error().kind, "bodies[" + std::to_string(i) + "]." + sound.error().message});
  }
  py::list ids;
  for (py::ssize_t i = 0; i < count; ++i) {
    go_to_row(i);
    ids.append(taken(world.use().add_body(definition)));
  }
  return ids;
}

void set_state(WorldValue& world, BodyId body, const py::object& position_m, const py::object& orientation_wxyz,
               const py::object& velocity_mps, const py::object& angular_velocity_radps) {
  BodyState state = taken(world.use().state(body));
  if (!position_m.is_none()) state.position_m = vec3_of("position_m", {position_m});
  if (!orientation_wxyz.is_none()) state.orientation = quat_of("orientation_wxyz", {orientation_wxyz});
  if (!velocity_mps.is_none()) state.velocity_mps = vec3_of("velocity_mps", {velocity_mps});
  if (!angular_velocity_radps.is_none())
    state.angular_velocity_radps = vec3_of("angular_velocity_radps", {angular_velocity_radps});
  check(world.use().set_state(body, state));
}

std::string text_of(BodyId body) {
  return "poise.BodyId(slot=" + std::to_string(body.slot) + ", generation=" + std::to_string(body.generation) + ")";
}

void bind_body_values(py::module_& module) {
  py::class_<BodyId>(module, "BodyId",
                     R"(Names a body of one World. A value: hashable, equal if slot and generation are.

A slot is used again when its body was removed, with another generation, so an old handle is refused
(poise.Error of the kind 'stale_handle').)")
      .def(py::init([](std::uint32_t slot, std::uint32_t generation) {
             return BodyId{slot, generation};
           }),
           py::arg("slot"), py::arg("generation"))
      .def_readonly("slot", &BodyId::slot, "Index of the body in the World; rows of states ascend by it.")
      .def_readonly("generation", &BodyId::generation, "How often the slot was used before.")
      .def("__eq__", [](BodyId a, const py::object& b) { return py::isinstance<BodyId>(b) && a == b.cast<BodyId>(); })
      .def("__hash__", [](BodyId body) { return py::hash(py::make_tuple(body.slot, body.generation)); })
      .def("__repr__", &text_of);
  py::class_<MaterialId>(module, "MaterialId", "Names a material of one World (World.add_material).")
      .def_readonly("index", &MaterialId::index, "Its number.");
  py::class_<BodyState>(module, "BodyState", "Position and motion of a body when it was asked for.")
      .def_property_readonly(
          "position_m", [](const BodyState& s) { return tuple_of(s.position_m); },
          "Centre of mass, world frame, metres.")
      .def_property_readonly(
          "orientation_wxyz", [](const BodyState& s) { return tuple_of(s.orientation); },
          "Axes of the mesh, body to world, unit quaternion, w first.")
      .def_property_readonly(
          "velocity_mps", [](const BodyState& s) { return tuple_of(s.velocity_mps); },
          "Of the centre of mass, world frame, m/s.")
      .def_property_readonly(
          "angular_velocity_radps", [](const BodyState& s) { return tuple_of(s.angular_velocity_radps); },
          "World frame, rad/s.")
      .def("__repr__", [](const BodyState& s) {
        return "<poise.BodyState at " + py::repr(tuple_of(s.position_m)).cast<std::string>() + " m>";
      });
}

void bind_adding(WorldClass& world) {
  const py::tuple zero = py::make_tuple(0.0, 0.0, 0.0);
  world
      .def("add_body", &add_body, py::arg("shape"), py::arg("material"), py::kw_only(), py::arg("motion") = "dynamic",
           py::arg("position_m") = zero, py::arg("orientation_wxyz") = py::make_tuple(1.0, 0.0, 0.0, 0.0),
           py::arg("velocity_mps") = zero, py::arg("angular_velocity_radps") = zero, py::arg("mass_kg") = 0.0,
           py::arg("inertia_kgm2") = zero, py::arg("group") = 1, py::arg("collides_with") = kMostBits,
           py::arg("importance") = 1.0, py::arg("user_data") = 0,
           R"(Adds a body; the result names it.

motion: 'dynamic', 'static', or 'kinematic' (moves as it is told, and is not pushed). position_m: of the origin
of the shape's mesh or list of spheres, world frame, metres. orientation_wxyz: body to world; normalised.
velocity_mps: of the centre of mass. angular_velocity_radps: world frame. mass_kg: 0 is volume times the
material's density. inertia_kgm2: principal moments; 0 is the shape's. group, collides_with: 32 bits each; a
pair collides if both agree. importance: factor on the priority of its pairs, in [0, 1e6]. user_data: an int
that your cue, policy and filter read.)")
      .def("add_bodies", &add_bodies, py::arg("shape"), py::arg("material"), py::arg("position_m"), py::kw_only(),
           py::arg("orientation_wxyz") = py::none(), py::arg("velocity_mps") = py::none(),
           py::arg("angular_velocity_radps") = py::none(), py::arg("user_data") = py::none(),
           py::arg("motion") = "dynamic", py::arg("mass_kg") = 0.0, py::arg("inertia_kgm2") = zero,
           py::arg("group") = 1, py::arg("collides_with") = kMostBits, py::arg("importance") = 1.0,
           R"(Adds a body for each row of position_m (n, 3), and returns their BodyIds, in the same order.

The other arrays have n rows: of 4 numbers for orientation_wxyz, of one for user_data (in [0, 2^63)), else of 3;
None is the default of add_body for all. Where one body is refused, none is added.)")
      .def(
          "add_material",
          [](WorldValue& w, double restitution, double friction, double density_kgpm3) {
            return taken(w.use().add_material({restitution, friction, density_kgpm3}));
          },
          py::kw_only(), py::arg("restitution") = 0.0, py::arg("friction") = 0.0, py::arg("density_kgpm3") = 1000.0,
          "Adds a material: restitution in [0, 1], Coulomb's friction in [0, 1e6], density in kg/m^3.")
      .def(
          "remove_body", [](WorldValue& w, BodyId body) { check(w.use().remove_body(body)); }, py::arg("body"),
          "Removes a body; its handle is refused from then on. Wakes what rested on it.")
      .def(
          "remove_material", [](WorldValue& w, MaterialId id) { check(w.use().remove_material(id)); },
          py::arg("material"), "Removes a material that no body uses.")
      .def("remove_shape", &WorldValue::remove_shape, py::arg("shape"), "Removes a shape that no body uses.");
}

void bind_reading(WorldClass& world) {
  // One without bodies is a World all the same.
  world.def("__bool__", [](const WorldValue&) { return true; });
  world.def("__contains__", [](WorldValue& w, BodyId body) { return w.use().contains(body); })
      .def("__len__", [](WorldValue& w) { return w.use().body_count(); })
      .def(
          "bodies",
          [](WorldValue& w) {
            py::list ids;
            for (const BodyId body : w.use().bodies()) ids.append(body);
            return ids;
          },
          "BodyIds of all bodies, static ones and planes too, in order of slots: the rows of states().")
      .def(
          "state", [](WorldValue& w, BodyId body) { return taken(w.use().state(body)); }, py::arg("body"),
          "BodyState of one body, a copy. For all bodies states() is faster.")
      .def(
          "motion",
          [](WorldValue& w, BodyId body) {
            return std::string(kMotions[static_cast<std::size_t>(taken(w.use().motion_type(body)))]);
          },
          py::arg("body"), "'static', 'kinematic' or 'dynamic'; a sleeping body is dynamic.")
      .def(
          "asleep", [](WorldValue& w, BodyId body) { return taken(w.use().asleep(body)); }, py::arg("body"),
          "Whether a body sleeps (Settings.sleeping).")
      .def(
          "mass_kg", [](WorldValue& w, BodyId body) { return taken(w.use().mass_kg(body)); }, py::arg("body"),
          "Mass, kg; 0 for static and kinematic bodies.")
      .def(
          "shape", [](WorldValue& w, BodyId body) { return ShapeValue{taken(w.use().shape(body))}; }, py::arg("body"),
          "The shape of a body.")
      .def(
          "user_data", [](WorldValue& w, BodyId body) { return taken(w.use().user_data(body)); }, py::arg("body"),
          "The caller's value of a body.");
}

void bind_changing(WorldClass& world) {
  world
      .def("set_state", &set_state, py::arg("body"), py::kw_only(), py::arg("position_m") = py::none(),
           py::arg("orientation_wxyz") = py::none(), py::arg("velocity_mps") = py::none(),
           py::arg("angular_velocity_radps") = py::none(),
           "Sets what is given of a body's state (centre of mass, world frame; m, m/s, rad/s) and leaves the rest.")
      .def(
          "set_user_data",
          [](WorldValue& w, BodyId body, const py::object& value) {
            check(w.use().set_user_data(body, whole_of("value", value, ~std::uint64_t{0})));
          },
          py::arg("body"), py::arg("value"), "Sets the caller's value of a body, an int in [0, 2^64).")
      .def(
          "set_groups",
          [](WorldValue& w, BodyId body, const py::object& group, const py::object& collides_with) {
            check(w.use().set_groups(body, static_cast<std::uint32_t>(whole_of("group", group, kMostBits)),
                                     static_cast<std::uint32_t>(whole_of("collides_with", collides_with, kMostBits))));
          },
          py::arg("body"), py::arg("group"), py::arg("collides_with"), "Sets the collision groups (32 bits each).")
      .def(
          "set_importance",
          [](WorldValue& w, BodyId body, double importance) { check(w.use().set_importance(body, importance)); },
          py::arg("body"), py::arg("importance"), "Sets the factor on the priority of its pairs, in [0, 1e6].")
      .def(
          "apply_force",
          [](WorldValue& w, BodyId body, const VectorArgument& force_n, const VectorArgument& point_m) {
            check(w.use().apply_force(body, vec3_of("force_n", force_n), vec3_of("point_m", point_m)));
          },
          py::arg("body"), py::arg("force_n"), py::arg("point_m"),
          "Adds a force (N) at a point (m), both in the world frame, for the next step, which clears it.")
      .def(
          "apply_torque",
          [](WorldValue& w, BodyId body, const VectorArgument& torque_nm) {
            check(w.use().apply_torque(body, vec3_of("torque_nm", torque_nm)));
          },
          py::arg("body"), py::arg("torque_nm"), "Adds a torque (N m, world frame) for the next step.")
      .def(
          "apply_impulse",
          [](WorldValue& w, BodyId body, const VectorArgument& impulse_ns, const VectorArgument& point_m) {
            check(w.use().apply_impulse(body, vec3_of("impulse_ns", impulse_ns), vec3_of("point_m", point_m)));
          },
          py::arg("body"), py::arg("impulse_ns"), py::arg("point_m"),
          "Changes velocities at once by an impulse (kg m/s) at a point (m), world frame.");
}

}  // namespace

void bind_bodies(py::module_& module, WorldClass& world) {
  bind_body_values(module);
  bind_adding(world);
  bind_reading(world);
  bind_changing(world);
}

}  // namespace poise::python
