// SPDX-License-Identifier: MIT
#include "frame/ccd/swept_contact.h"

#include <utility>

#include "collision/triangles/polygon_contact.h"
#include "frame/stages.h"

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

// The poses of two bodies while they stand somewhere else.
class OtherPoses {
 public:
  OtherPoses(FrameBuffers& buffers, const ActivePair& pair, const collision::TimeOfImpact& impact)
      : a_(buffers.poses[pair.a]),
        b_(buffers.poses[pair.b]),
        cached_a_(std::exchange(a_, {impact.a.position_m, collision::turn_of(impact.a)})),
        cached_b_(std::exchange(b_, {impact.b.position_m, collision::turn_of(impact.b)})) {}
  ~OtherPoses() {
    a_ = cached_a_;
    b_ = cached_b_;
  }
  OtherPoses(const OtherPoses&) = delete;
  OtherPoses& operator=(const OtherPoses&) = delete;

 private:
  collision::Pose& a_;
  collision::Pose& b_;
  collision::Pose cached_a_, cached_b_;
};

}  // namespace

double swept_slack_m(const WorldState& world, std::size_t slot) {
  return 0.5 * world.shapes[world.shape_of[slot]].least_extent_m;
}

void refine_whole(WorldState& world, ActivePair& pair, collision::LevelContact& found, int worker) {
  collision::FrontPool& pool = world.buffers.pools[static_cast<std::size_t>(worker)];
  pool.clear();
  refine_pair(world, pair, found, worker);
  pool.clear();
  pair.level.front = {};
  pair.level.front_entries = 0;
}

collision::PairContact contact_where_met(WorldState& world, const ActivePair& pair,
                                         const collision::TimeOfImpact& impact) {
  // Wider than a hit stands apart, so that a face that lies flat counts whole.
  constexpr double kBandOfGap = 4;
  constexpr double kSameSide = 0.5;
  const collision::PairContact single = impact_contact(impact);
  const Shape& a = *impact.a.shape;
  const Shape& b = *impact.b.shape;
  if (!has_faces(a) || !has_faces(b)) return single;
  const OtherPoses poses(world.buffers, pair, impact);
  ActivePair there;
  there.a = pair.a;
  there.b = pair.b;
  there.skin_m = pair.skin_m;
  there.margin_m = there.reach_m = kBandOfGap * impact.contact.gap_m;
  there.level.deepest = collision::deepest_level(a, b, kMaxTreeDepth);
  collision::allow_polygons(a, b, kMaxTreeDepth, there.level);
  collision::LevelContact found;
  refine_whole(world, there, found, 0);
  const collision::PairContact& full = found.contact;
  const bool sound = !there.full && there.level.by_polygons() && full.present && full.direction.norm() > kSameSide &&
                     full.direction.normalized().dot(single.direction) > kSameSide;
  return sound ? full : single;
}

}  // namespace poise::simulation
