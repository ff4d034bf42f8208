// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "collision/front/front.h"
#include "collision/front/pair_frame.h"
#include "collision/manifold/fitted_sums.h"
#include "poise/types.h"

namespace poise::collision {

/// One contact of two spheres, or of a sphere and a plane, in the frame of a.
struct SphereContact {
  Vec3 normal = Vec3::UnitZ();  ///< from a to b, unit
  Vec3 point_m = Vec3::Zero();  ///< DO eq. 5: on the centre line in proportion of the radii; for a plane o + R n
  double gap_m = 0;             ///< between the two spheres, negative in overlap
};

/// Centres that are nearer than this share of the sum of the radii coincide.
inline constexpr double kCoinciding = 1e-12;

/// The contact of one entry of a front, in double precision from the node indices (DO eq. 4, 5). Coinciding centres
/// take the direction between the two centres of mass, and the z axis of a when these coincide as well.
SphereContact sphere_contact(const PairFrame& frame, FrontEntry entry);

/// The same for two spheres whose centres are `between_m` apart (from a to b), with `reach_m` the sum of their radii;
/// the point is measured from the centre of a. `fallback` is the direction that coinciding centres take, if it is not
/// zero.
SphereContact contact_of_spheres(const Vec3& between_m, double radius_a_m, double reach_m, const Vec3& fallback);

/// Weighted sums over the entries of a front, which make one wrench (docs/method.md). Sums of parts add up, so a front
/// may be summed in pieces, in order.
struct WrenchSum {
  double weight_m = 0;            ///< sum of w
  Vec3 direction = Vec3::Zero();  ///< sum of w n
  Vec3 moment_m2 = Vec3::Zero();  ///< sum of w c x n, about the centre of mass of a
  Vec3 place_m2 = Vec3::Zero();   ///< sum of w c
};

/// Sums over a front. With PairFrame::fitted `fitted` counts, or `fitted_near` while it is empty. Otherwise two
/// wrenches of the same front: `touching` weighs by w = skin - gap over the entries with gap < skin; `near` by w =
/// margin - gap over all. The second counts only while nothing touches.
struct ContactSums {
  WrenchSum touching;
  WrenchSum near;
  double spheres_m = 1e300;               ///< least gap of two spheres
  double estimated_separation_m = 1e300;  ///< least gap plus mean protrusion of both nodes
  double certain_separation_m = 1e300;    ///< least gap plus largest protrusion of both nodes
  FittedSums fitted, fitted_near;
  bool gaps_only = false;  ///< with PairFrame::fitted: a deeper level follows at once, which reads no more
};

void add_to_sums(const PairFrame& frame, std::span<const FrontEntry> entries, ContactSums& sums);

/// Whether the entries that are near count: where so many more are close, and as yet none was.
inline bool counts_near(std::size_t close, const ContactSums& sums) { return close == 0 && sums.fitted.weight == 0; }
/// With PairFrame::fitted: entries that are close count; while there are none, those that are near do.
void add_close(const PairFrame& frame, std::span<const FrontEntry> near, std::span<const FrontEntry> close,
               ContactSums& sums);

/// The contact of a pair: one wrench about the two centres of mass, world frame, and the separation of the surfaces.
struct PairContact {
  Vec3 direction = Vec3::Zero();      ///< l, from a to b, |l| <= 1
  Vec3 moment_a_m = Vec3::Zero();     ///< t_a = sum w (c - x_a) x n / sum w
  Vec3 moment_b_m = Vec3::Zero();     ///< t_b = sum w (c - x_b) x n / sum w
  Vec3 arm_m = Vec3::Zero();          ///< mean contact point from the centre of mass of a
  double spheres_m = 0;               ///< least gap of two spheres; not known with PairFrame::fitted
  double estimated_separation_m = 0;  ///< estimated separation of the two surfaces, least over the front
  double certain_separation_m = 0;    ///< below zero the two surfaces penetrate certainly
  bool present = false;               ///< something is nearer than the margin
};

/// The contacts of the first `count` entries: of the fitted spheres with PairFrame::fitted, otherwise of the nodes' own
/// spheres with their estimated separation. All entries name nodes; the lanes of those beyond the first say nothing.
void node_contacts(const PairFrame& frame, std::span<const FrontEntry, NodeContacts::kLanes> entries, std::size_t count,
                   NodeContacts& into);

/// Of sums of gaps alone, no more of the contact than its separations and whether it is present. Made in its place: a
/// copy of what has just been written in small parts waits for them.
void make_contact(const PairFrame& frame, const ContactSums& sums, const Mat3& rotation_a, PairContact& contact);

}  // namespace poise::collision
