// SPDX-License-Identifier: MIT
#include "frame/contact_points.h"

#include <algorithm>

namespace poise::simulation {
namespace {

static_assert(Contact::kMostPoints == collision::kMaxManifoldPoints);

// Makes the mean forces of the points in the last substep their impulses in the whole step.
void share_out(const Vec3& whole_ns, double dt_s, std::span<ContactPoint> points) {
  Vec3 borne = Vec3::Zero();
  double load = 0;
  for (const ContactPoint& point : points) {
    borne += point.impulse_ns;
    load += std::abs(point.impulse_ns.dot(point.normal));
  }
  const double square = borne.squaredNorm();
  // Forces that hold each other in balance say little of what the pair gave: no point had its force for longer than the
  // step took.
  const double scale = square > 0 ? std::clamp(whole_ns.dot(borne) / square, 0.0, dt_s) : 0.0;
  const Vec3 left = whole_ns - scale * borne;
  for (ContactPoint& point : points) {
    const double share =
        load > 0 ? std::abs(point.impulse_ns.dot(point.normal)) / load : 1.0 / static_cast<double>(points.size());
    point.impulse_ns = scale * point.impulse_ns + share * left;
  }
}

}  // namespace

void list_points(const ListedPair& listed, double sign, Contact& contact) {
  const PairPoints& made = listed.made;
  // The first of several is for impacts alone.
  const std::size_t begin = PointCache::manifold_begin(made.slot, made.point_count);
  const std::size_t count = std::min(PointCache::manifold_count(made.point_count), Contact::kMostPoints);
  const collision::Pose& a = listed.motion.poses[listed.pair.a];
  const collision::Pose& b = listed.motion.poses[listed.pair.b];
  for (std::size_t k = 0; k < count; ++k) {
    const solver::PlacedPoint placed = solver::placed_point(a, b, listed.points.points[begin + k]);
    const solver::ContactForce& load = listed.points.forces[begin + k];
    ContactPoint& point = contact.point_slots[k];
    point.point_m = a.position_m + placed.arm_m;
    point.normal = sign * placed.normal;
    point.separation_m = placed.gap_m;
    point.impulse_ns = sign * (load.normal_n * placed.normal + load.friction_n);
  }
  contact.point_count = static_cast<std::uint8_t>(count);
  share_out(contact.impulse_ns, listed.dt_s, std::span(contact.point_slots).first(count));
}

void merge_points(const Contact& from, Contact& into) {
  for (const ContactPoint& point : from.points()) {
    if (into.point_count < Contact::kMostPoints) {
      into.point_slots[into.point_count++] = point;
      continue;
    }
    const auto nearest = std::min_element(
        into.point_slots.begin(), into.point_slots.end(), [&](const ContactPoint& x, const ContactPoint& y) {
          return (x.point_m - point.point_m).squaredNorm() < (y.point_m - point.point_m).squaredNorm();
        });
    nearest->impulse_ns += point.impulse_ns;
  }
}

}  // namespace poise::simulation
