// SPDX-License-Identifier: MIT
#include "collision/manifold/contact_sums.h"

#include <algorithm>
#include <cmath>

#include "collision/manifold/contact_batch.h"

namespace poise::collision {
namespace {

void finish_gaps(const FittedSums& sums, PairContact& contact) {
  contact.certain_separation_m = sums.cores_m;
  // Certain penetration counts whatever the fitted spheres say.
  contact.estimated_separation_m = std::min(sums.fitted_m, sums.cores_m);
  contact.present = true;
}

/// One impulse along the mean direction at the mean point (DO eq. 1).
void finish_fitted(const PairFrame& frame, const FittedSums& sums, const Mat3& rotation_a, PairContact& contact) {
  Vec3 direction = sums.direction;
  if (direction.isZero(0)) direction = frame.with_plane() ? Vec3(-frame.plane_normal) : frame.offset_m;
  if (direction.isZero(0)) direction = Vec3::UnitZ();
  contact.direction = (rotation_a * direction).normalized();
  contact.arm_m.noalias() = rotation_a * (sums.point_m / sums.weight);
  contact.moment_a_m = contact.arm_m.cross(contact.direction);
  contact.moment_b_m = (contact.arm_m - rotation_a * frame.offset_m).cross(contact.direction);
  contact.spheres_m = 0;
  finish_gaps(sums, contact);
}

void add_weighted(WrenchSum& sum, double weight, const SphereContact& contact) {
  const Vec3 normal = weight * contact.normal;
  sum.weight_m += weight;
  sum.direction += normal;
  sum.moment_m2 += contact.point_m.cross(normal);
  sum.place_m2 += weight * contact.point_m;
}

void note_gap(double gap_m, double expected_m, double certain_m, ContactSums& sums) {
  sums.spheres_m = std::min(sums.spheres_m, gap_m);
  sums.estimated_separation_m = std::min(sums.estimated_separation_m, gap_m + expected_m);
  sums.certain_separation_m = std::min(sums.certain_separation_m, gap_m + certain_m);
}

void add_plane_contacts(const PairFrame& frame, std::span<const FrontEntry> entries, ContactSums& sums) {
  const SphereTree& a = frame.a->tree;
  for (const FrontEntry entry : entries) {
    const SphereContact contact = sphere_contact(frame, entry);
    if (contact.gap_m >= frame.margin_m) continue;
    note_gap(contact.gap_m, static_cast<double>(a.protrusion_mean_m[entry.a]),
             static_cast<double>(a.protrusion_max_m[entry.a]), sums);
    if (contact.gap_m < frame.skin_m) {
      add_weighted(sums.touching, frame.skin_m - contact.gap_m, contact);
    }
    if (sums.touching.weight_m == 0) {
      add_weighted(sums.near, frame.margin_m - contact.gap_m, contact);
    }
  }
}

// Adds the first `count` wrenches of a batch, in order.
void add_wrenches(const ContactBatch& batch, std::size_t count, WrenchSum& sum) {
  WrenchSum total = sum;
  const auto at = [](const ContactBatch::Vectors& from, std::size_t k) {
    return Vec3(from.x[k], from.y[k], from.z[k]);
  };
  for (std::size_t k = 0; k < count; ++k) {
    total.weight_m += batch.weight_m[k];
    total.direction += at(batch.direction, k);
    total.moment_m2 += at(batch.moment_m2, k);
    total.place_m2 += at(batch.place_m2, k);
  }
  sum = total;
}

void add_batch(const PairFrame& frame, ContactBatch& batch, ContactSums& sums) {
  for (std::size_t k = 0; k < batch.count; ++k) {
    if (batch.gap_m[k] < frame.margin_m) note_gap(batch.gap_m[k], batch.expected_m[k], batch.certain_m[k], sums);
  }
  const bool touched = sums.touching.weight_m != 0;
  set_wrenches(frame.skin_m, frame.margin_m, batch);
  // Near contacts count until the first touching one.
  std::size_t near = 0;
  if (!touched) {
    while (near < batch.count && batch.weight_m[near] == 0) ++near;
  }
  if (near < batch.count) add_wrenches(batch, batch.count, sums.touching);
  if (near > 0) {
    set_wrenches(frame.margin_m, frame.margin_m, batch);
    add_wrenches(batch, near, sums.near);
  }
}

}  // namespace

SphereContact contact_of_spheres(const Vec3& between_m, double radius_a_m, double reach_m, const Vec3& fallback) {
  const double distance = between_m.norm();
  SphereContact contact;
  if (distance > kCoinciding * reach_m) {
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
  if (frame.fitted) {
    add_close(frame, {}, entries, sums);
    return;
  }
  if (frame.with_plane()) {
    add_plane_contacts(frame, entries, sums);
    return;
  }
  ContactBatch batch;
  for (std::size_t begin = 0; begin < entries.size(); begin += ContactBatch::kEntries) {
    set_contacts(frame, entries.subspan(begin, std::min(ContactBatch::kEntries, entries.size() - begin)), batch);
    add_batch(frame, batch, sums);
  }
}

void add_close(const PairFrame& frame, std::span<const FrontEntry> near, std::span<const FrontEntry> close,
               ContactSums& sums) {
  const auto add = sums.gaps_only ? add_least_gaps : add_fitted;
  if (counts_near(close.size(), sums)) {
    add(frame, near, sums.fitted_near);
  } else {
    add(frame, close, sums.fitted);
  }
}

void node_contacts(const PairFrame& frame, std::span<const FrontEntry, NodeContacts::kLanes> entries, std::size_t count,
                   NodeContacts& into) {
  if (frame.fitted) {
    fitted_contacts(frame, entries, into);
    return;
  }
  for (std::size_t k = 0; k < count; ++k) {
    const FrontEntry entry = entries[k];
    const SphereContact contact = sphere_contact(frame, entry);
    double expected = static_cast<double>(frame.a->tree.protrusion_mean_m[entry.a]);
    double certain = static_cast<double>(frame.a->tree.protrusion_max_m[entry.a]);
    if (!frame.with_plane()) {
      expected += static_cast<double>(frame.b->tree.protrusion_mean_m[entry.b]);
      certain += static_cast<double>(frame.b->tree.protrusion_max_m[entry.b]);
    }
    if (frame.by_spheres) expected = 0;
    into.gap_m[k] = static_cast<float>(contact.gap_m + expected);
    into.certain_separation_m[k] = static_cast<float>(contact.gap_m + certain);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      into.normal[axis][k] = static_cast<float>(contact.normal[static_cast<Eigen::Index>(axis)]);
      into.point_m[axis][k] = static_cast<float>(contact.point_m[static_cast<Eigen::Index>(axis)]);
    }
  }
}

void make_contact(const PairFrame& frame, const ContactSums& sums, const Mat3& rotation_a, PairContact& contact) {
  if (frame.fitted) {
    const FittedSums& sum = sums.fitted.weight > 0 ? sums.fitted : sums.fitted_near;
    if (!(sum.weight > 0)) {
      contact = {};
    } else if (sums.gaps_only) {
      finish_gaps(sum, contact);
    } else {
      finish_fitted(frame, sum, rotation_a, contact);
    }
    return;
  }
  const WrenchSum& sum = sums.touching.weight_m > 0 ? sums.touching : sums.near;
  if (!(sum.weight_m > 0)) {
    contact = {};
    return;
  }
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
  contact.estimated_separation_m = sums.estimated_separation_m;
  contact.certain_separation_m = sums.certain_separation_m;
  contact.present = true;
}

}  // namespace poise::collision
