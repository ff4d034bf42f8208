// SPDX-License-Identifier: MIT
#include <limits>
#include <optional>
#include <vector>

#include <pybind11/stl.h>

#include "world_value.h"

namespace poise::python {
namespace {

constexpr double kFarthest = std::numeric_limits<double>::infinity();

QueryFilter filter_of(const py::object& group, const py::object& collides_with, const py::object& ignore) {
  QueryFilter filter;
  filter.group = static_cast<std::uint32_t>(whole_of("group", group, 0xffffffffU));
  filter.collides_with = static_cast<std::uint32_t>(whole_of("collides_with", collides_with, 0xffffffffU));
  if (!ignore.is_none()) filter.ignore = typed<BodyId>("ignore", ignore, "a poise.BodyId or None");
  return filter;
}

py::list listed(const std::vector<BodyId>& bodies) {
  py::list ids;
  for (const BodyId body : bodies) ids.append(body);
  return ids;
}

void bind_query_values(py::module_& module) {
  py::class_<RayHit>(module, "RayHit", "The first point of a ray on a body.")
      .def_readonly("body", &RayHit::body, "BodyId.")
      .def_property_readonly(
          "point_m", [](const RayHit& h) { return tuple_of(h.point_m); }, "Metres, world frame.")
      .def_property_readonly(
          "normal", [](const RayHit& h) { return tuple_of(h.normal); }, "Unit, out of the body.")
      .def_readonly("distance_m", &RayHit::distance_m, "Along the ray, metres.");
  py::class_<SphereCastHit>(module, "SphereCastHit", "The first touch of a moving sphere.")
      .def_readonly("body", &SphereCastHit::body, "BodyId.")
      .def_property_readonly(
          "point_m", [](const SphereCastHit& h) { return tuple_of(h.point_m); }, "On the surface of the body, metres.")
      .def_property_readonly(
          "normal", [](const SphereCastHit& h) { return tuple_of(h.normal); }, "Unit, from the body to the sphere.")
      .def_readonly("distance_m", &SphereCastHit::distance_m, "Travelled by the sphere, metres.")
      .def_readonly("overlaps_at_start", &SphereCastHit::overlaps_at_start, "Whether it overlapped at its start.");
  py::class_<ClosestPoint>(module, "ClosestPoint", "The point of a body's surface that is nearest to another point.")
      .def_readonly("body", &ClosestPoint::body, "BodyId.")
      .def_property_readonly(
          "point_m", [](const ClosestPoint& p) { return tuple_of(p.point_m); }, "Metres.")
      .def_property_readonly(
          "normal", [](const ClosestPoint& p) { return tuple_of(p.normal); },
          "Unit, the direction in which distance_m grows.")
      .def_readonly("distance_m", &ClosestPoint::distance_m, "Metres, negative inside a solid.");
}

void bind_casts(WorldClass& world) {
  const auto all = py::int_(0xffffffffU);
  world
      .def(
          "cast_ray",
          [](WorldValue& w, const VectorArgument& origin_m, const VectorArgument& direction, double max_distance_m,
             bool leaves_solids, const py::object& group, const py::object& collides_with, const py::object& ignore) {
            return taken(w.use().cast_ray(
                {vec3_of("origin_m", origin_m), vec3_of("direction", direction), max_distance_m, leaves_solids},
                filter_of(group, collides_with, ignore)));
          },
          py::arg("origin_m"), py::arg("direction"), py::kw_only(), py::arg("max_distance_m") = kFarthest,
          py::arg("leaves_solids") = false, py::arg("group") = all, py::arg("collides_with") = all,
          py::arg("ignore") = py::none(),
          R"(The first body that a ray hits (RayHit), or None. On true surfaces, metres, world frame (docs/queries.md).

direction may have any length but 0. leaves_solids: for a ray that begins inside a solid, where it leaves it.
group, collides_with: bits as of bodies. ignore: a body that is not found.)")
      .def(
          "cast_sphere",
          [](WorldValue& w, const VectorArgument& center_m, double radius_m, const VectorArgument& direction,
             double max_distance_m, const py::object& group, const py::object& collides_with,
             const py::object& ignore) {
            return taken(w.use().cast_sphere(
                {vec3_of("center_m", center_m), radius_m, vec3_of("direction", direction), max_distance_m},
                filter_of(group, collides_with, ignore)));
          },
          py::arg("center_m"), py::arg("radius_m"), py::arg("direction"), py::kw_only(),
          py::arg("max_distance_m") = kFarthest, py::arg("group") = all, py::arg("collides_with") = all,
          py::arg("ignore") = py::none(), "The first body that a moving sphere touches (SphereCastHit), or None.");
}

}  // namespace

void bind_queries(py::module_& module, WorldClass& world) {
  const auto all = py::int_(0xffffffffU);
  bind_query_values(module);
  bind_casts(world);
  world
      .def(
          "overlap_sphere",
          [](WorldValue& w, const VectorArgument& center_m, double radius_m, const py::object& group,
             const py::object& collides_with, const py::object& ignore) {
            std::vector<BodyId> found;
            check(w.use().overlap_sphere(vec3_of("center_m", center_m), radius_m, found,
                                         filter_of(group, collides_with, ignore)));
            return listed(found);
          },
          py::arg("center_m"), py::arg("radius_m"), py::kw_only(), py::arg("group") = all,
          py::arg("collides_with") = all, py::arg("ignore") = py::none(),
          "BodyIds of the bodies that overlap a ball, in order of slots.")
      .def(
          "overlap_box",
          [](WorldValue& w, const VectorArgument& center_m, const VectorArgument& half_extents_m,
             const QuaternionArgument& orientation_wxyz, const py::object& group, const py::object& collides_with,
             const py::object& ignore) {
            std::vector<BodyId> found;
            check(w.use().overlap_box({vec3_of("center_m", center_m), vec3_of("half_extents_m", half_extents_m),
                                       quat_of("orientation_wxyz", orientation_wxyz)},
                                      found, filter_of(group, collides_with, ignore)));
            return listed(found);
          },
          py::arg("center_m"), py::arg("half_extents_m"), py::kw_only(),
          py::arg("orientation_wxyz") = py::make_tuple(1.0, 0.0, 0.0, 0.0), py::arg("group") = all,
          py::arg("collides_with") = all, py::arg("ignore") = py::none(),
          "BodyIds of the bodies that overlap a box, in order of slots.")
      .def(
          "closest_point",
          [](WorldValue& w, const VectorArgument& point_m, const py::object& body, double max_distance_m,
             const py::object& group, const py::object& collides_with,
             const py::object& ignore) -> std::optional<ClosestPoint> {
            const Vec3 point = vec3_of("point_m", point_m);
            if (!body.is_none())
              return taken(w.use().closest_point(typed<BodyId>("body", body, "a poise.BodyId or None"), point));
            return taken(w.use().closest_point(point, max_distance_m, filter_of(group, collides_with, ignore)));
          },
          py::arg("point_m"), py::kw_only(), py::arg("body") = py::none(), py::arg("max_distance_m") = kFarthest,
          py::arg("group") = all, py::arg("collides_with") = all, py::arg("ignore") = py::none(),
          "The nearest point on any body's surface, or on that of `body` (ClosestPoint); None if there is none.");
}

}  // namespace poise::python
