// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "poise/queries.h"
#include "poise/result.h"
#include "poise/shape.h"
#include "query/body_surface.h"
#include "query/body_tree.h"

namespace poise::query {

/// The bodies that queries use: one entry a slot, all spans of equal length. Positions are those of the centre of mass;
/// orientations are unit, body to world.
struct BodyViews {
  std::span<const double> x_m, y_m, z_m;
  std::span<const double> qw, qx, qy, qz;
  std::span<const ShapePtr> shape;  ///< not null where alive
  std::span<const std::uint8_t> alive;
  std::span<const std::uint32_t> generation;
  std::span<const std::uint32_t> group, collides_with;

  [[nodiscard]] std::size_t slot_count() const { return alive.size(); }
  [[nodiscard]] Vec3 position(std::size_t i) const { return {x_m[i], y_m[i], z_m[i]}; }
  [[nodiscard]] Mat3 rotation(std::size_t i) const { return Quat(qw[i], qx[i], qy[i], qz[i]).toRotationMatrix(); }
};

/// A tree over the boxes of living bodies, and the surfaces of their shapes. Invariant: every living body is either in
/// the tree or among the planes, and the surface of its shape is present.
///
/// update() must be called by one thread after a body was moved, added, removed or changed its shape. The queries are
/// const, and any number of threads may query at once. Queries do not check their arguments: see query/checks.h. If
/// several bodies are at the same distance, the one with the lowest slot is returned.
class BodyIndex {
 public:
  /// Linear in the slots. Reuses the surfaces of known shapes, and the shape of the tree as long as it is good.
  void update(const BodyViews& bodies);

  [[nodiscard]] std::optional<RayHit> cast_ray(const BodyViews& bodies, const Ray& ray,
                                               const QueryFilter& filter) const;
  [[nodiscard]] std::optional<SphereCastHit> cast_sphere(const BodyViews& bodies, const SphereCast& cast,
                                                         const QueryFilter& filter) const;
  /// Ids in ascending order of slots; the content of `found` is replaced.
  void overlap_sphere(const BodyViews& bodies, const Vec3& center_m, double radius_m, const QueryFilter& filter,
                      std::vector<BodyId>& found) const;
  void overlap_box(const BodyViews& bodies, const OrientedBox& box, const QueryFilter& filter,
                   std::vector<BodyId>& found) const;
  [[nodiscard]] std::optional<ClosestPoint> closest_point(const BodyViews& bodies, const Vec3& point_m,
                                                          double max_distance_m, const QueryFilter& filter) const;
  /// The nearest point on one living body.
  [[nodiscard]] ClosestPoint closest_point(const BodyViews& bodies, BodyId body, const Vec3& point_m) const;

 private:
  struct Nearest;
  [[nodiscard]] const BodySurface& surface_of(std::uint32_t slot) const { return *surfaces_[surface_of_slot_[slot]]; }
  /// Calls visit(slot) for the bodies whose box is not excluded by bound(low, high), and for all planes.
  template <class Bound, class Limit, class Visit>
  void visit_bodies(const BodyViews& bodies, const QueryFilter& filter, Bound&& bound, Limit&& limit,
                    Visit&& visit) const;

  BodyTree tree_;
  std::vector<geometry::Bounds> boxes_;     ///< of the bodies in the tree
  std::vector<std::uint32_t> slot_of_box_;  ///< ascending
  std::vector<std::uint32_t> planes_;       ///< slots
  std::vector<std::uint32_t> surface_of_slot_;
  std::vector<std::unique_ptr<BodySurface>> surfaces_;  ///< one a shape of a living body
};

}  // namespace poise::query
