// SPDX-License-Identifier: MIT
#include "collision/contact_sums.h"

#include <algorithm>
#include <cmath>

namespace poise::collision {
namespace {

void add_weighted(WrenchSum& sum, double weight, const SphereContact& contact) {
  const Vec3 normal = weight * contact.normal;
  sum.weight_m += weight;
  sum.direction += normal;
  sum.moment_m2 += contact.point_m.cross(normal);
  sum.place_m2 += weight * contact.point_m;
}

}  // namespace

SphereContact contact_of_spheres(const Vec3& between_m, double radius_a_m, double reach_m, const Vec3& fallback) {
  const double distance = between_m.norm();
  SphereContact contact;
  if (distance > 1e-12 * reach_m) {
    contact.normal = between_m / distance;
  } else if (fallback.squaredNorm() > 0) {
    contact.normal = fallback.normalized();
  }
  contact.point_m = between_m * (radius_a_m / reach_m);
  contact.gap_m = distance - reach_m;
  return contact;
}

SphereContact sphere_contact(const PairFrame& frame, FrontEntry entry) {
  const Sphere a = frame.a->tree.sphere(entry.a);
  if (!frame.with_plane()) {
    const Sphere b = frame.b->tree.sphere(entry.b);
    SphereContact contact = contact_of_spheres(frame.rotation * b.center_m + frame.offset_m - a.center_m, a.radius_m,
                                               a.radius_m + b.radius_m, frame.offset_m);
    contact.point_m += a.center_m;
    return contact;
  }
  SphereContact contact;
  contact.normal = -frame.plane_normal;
  contact.point_m = a.center_m + a.radius_m * contact.normal;
  contact.gap_m = frame.plane_normal.dot(a.center_m) - frame.plane_height_m - a.radius_m;
  return contact;
}

void add_to_sums(const PairFrame& frame, std::span<const FrontEntry> entries, ContactSums& sums) {
  const bool plane = frame.with_plane();
  const SphereTree& a = frame.a->tree;
  const SphereTree& b = frame.b->tree;
  for (const FrontEntry entry : entries) {
    const SphereContact contact = sphere_contact(frame, entry);
    if (contact.gap_m >= frame.margin_m) continue;
    double expected = static_cast<double>(a.protrusion_mean_m[entry.a]);
    double certain = static_cast<double>(a.protrusion_max_m[entry.a]);
    if (!plane) {
      expected += static_cast<double>(b.protrusion_mean_m[entry.b]);
      certain += static_cast<double>(b.protrusion_max_m[entry.b]);
    }
    sums.spheres_m = std::min(sums.spheres_m, contact.gap_m);
    sums.likely_m = std::min(sums.likely_m, contact.gap_m + expected);
    sums.surely_m = std::min(sums.surely_m, contact.gap_m + certain);
    if (contact.gap_m < frame.skin_m) {
      add_weighted(sums.touching, frame.skin_m - contact.gap_m, contact);
    }
    if (sums.touching.weight_m == 0) {
      add_weighted(sums.near, frame.margin_m - contact.gap_m, contact);
    }
  }
}

PairContact finish_contact(const PairFrame& frame, const ContactSums& sums, const Mat3& rotation_a) {
  PairContact contact;
  const WrenchSum& sum = sums.touching.weight_m > 0 ? sums.touching : sums.near;
  if (!(sum.weight_m > 0)) return contact;
  const double scale = 1.0 / sum.weight_m;
  const Vec3 direction = scale * sum.direction;
  const Vec3 moment_a = scale * sum.moment_m2;
  // c - x_b = (c - x_a) - (x_b - x_a), so the moment about b needs no sum of its own.
  const Vec3 moment_b = moment_a - frame.offset_m.cross(direction);
  contact.direction = rotation_a * direction;
  contact.moment_a_m = rotation_a * moment_a;
  contact.moment_b_m = rotation_a * moment_b;
  contact.arm_m = rotation_a * (scale * sum.place_m2);
  contact.spheres_m = sums.spheres_m;
  contact.likely_m = sums.likely_m;
  contact.surely_m = sums.surely_m;
  contact.present = true;
  return contact;
}

}  // namespace poise::collision
