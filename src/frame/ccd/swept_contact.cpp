// SPDX-License-Identifier: MIT
#include "frame/ccd/swept_contact.h"

#include "collision/triangles/polygon_contact.h"

namespace poise::simulation {
namespace {

bool has_faces(const Shape& shape) { return shape.surface != nullptr || shape.kind == ShapeKind::Plane; }

collision::PairContact impact_contact(const collision::TimeOfImpact& impact) {
  collision::PairContact contact;
  contact.present = true;
  contact.direction = impact.contact.normal;
  contact.arm_m = impact.contact.point_m - impact.a.position_m;
  contact.moment_a_m = contact.arm_m.cross(contact.direction);
  contact.moment_b_m = (impact.contact.point_m - impact.b.position_m).cross(contact.direction);
  contact.spheres_m = contact.estimated_separation_m = contact.certain_separation_m = impact.contact.gap_m;
  return contact;
}

}  // namespace

collision::PairContact contact_where_met(const PairRefiner& refiner, const ActivePair& pair,
                                         const collision::TimeOfImpact& impact, collision::FrontPool& scratch) {
  // Wider than a hit stands apart, so that a face that lies flat counts whole.
  constexpr double kBandOfGap = 4;
  constexpr double kSameSide = 0.5;
  const collision::PairContact single = impact_contact(impact);
  const Shape& a = *impact.a.shape;
  const Shape& b = *impact.b.shape;
  if (!has_faces(a) || !has_faces(b)) return single;
  const collision::Pose pose_a{impact.a.position_m, collision::turn_of(impact.a)};
  const collision::Pose pose_b{impact.b.position_m, collision::turn_of(impact.b)};
  ActivePair there;
  there.a = pair.a;
  there.b = pair.b;
  there.skin_m = pair.skin_m;
  there.margin_m = there.reach_m = kBandOfGap * impact.contact.gap_m;
  PairProgress progress;
  progress.level.deepest = collision::deepest_level(a, b, kMaxTreeDepth);
  collision::allow_polygons(a, b, kMaxTreeDepth, progress.level);
  collision::LevelContact found;
  refine_whole(refiner, {there, pose_a, pose_b}, progress, found, scratch);
  const collision::PairContact& full = found.contact;
  const bool sound = !progress.full && progress.level.by_polygons() && full.present &&
                     full.direction.norm() > kSameSide && full.direction.normalized().dot(single.direction) > kSameSide;
  return sound ? full : single;
}

}  // namespace poise::simulation
