// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "collision/triangles/convex_gap.h"
#include "dynamics/rotation.h"
#include "poise/shape.h"
#include "poise/types.h"

namespace poise::collision {

/// A moving body: its centre of mass moves straight at constant velocity, and it rotates freely. World frame.
struct MovingBody {
  const Shape* shape = nullptr;
  Vec3 position_m = Vec3::Zero();  ///< of the centre of mass
  Vec3 velocity_mps = Vec3::Zero();
  dynamics::Rotation rotation;       ///< principal frame to world, and spin
  Vec3 moments_kgm2 = Vec3::Zero();  ///< principal; zero for what does not turn
};

/// The same body `time_s` later.
MovingBody moved_on(const MovingBody& moving_body, double time_s);
/// Body frame to world.
Mat3 turn_of(const MovingBody& moving_body);

/// How near the true surfaces of two bodies are (triangles where a shape has them, else the leaves of its tree; b may
/// be a plane), `limit_m` with a zero normal where nothing is nearer than that. Bodies with triangles have no negative
/// gap: 0 where they cross.
ConvexGap surface_gap(const MovingBody& a, const MovingBody& b, double limit_m);

/// Time of impact of two bodies and their contact then.
struct TimeOfImpact {
  enum class Kind : std::uint8_t {
    None,  ///< no impact within the time
    Hit,   ///< the gap has come down to the tolerance, and they close
    Cut,   ///< no impact up to this time; the work limit of the pair ended the search
  };
  Kind kind = Kind::None;
  double time_s = 0;
  MovingBody a, b;    ///< both at that time
  ConvexGap contact;  ///< of a hit, world frame
};

/// Work limits of a time of impact query, and the distance that counts as touching.
struct ImpactTerms {
  double duration_s = 0;                    ///< >= 0
  double tolerance_m = 0;                   ///< > 0; a hit stands between half of it and all of it apart
  std::uint32_t max_node_pairs = 1U << 16;  ///< limit of node and part pairs that are tested
  std::uint32_t max_rounds = 64;            ///< limit of advancement rounds of rotating bodies
};

/// The first moment within the duration at which the surfaces come as near as the tolerance while they close. b may be
/// a plane. Conservative advancement (Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996) whose
/// bounds are taken pair of nodes by pair of nodes, nearest in time first (as Tang, Kim and Manocha, "C2A", 2009): two
/// balls that move straight meet when |p + v t| <= r + s t, with s what turning adds; two convex parts cannot meet
/// before their gap is used up by what closes along its normal. Without turning the time is exact to the tolerance.
/// Within the tolerance, what would use up no more than a quarter of its gap in all the time that is left is no hit but
/// slides. Overlap at the start is not looked at. Any thread, allocates nothing.
TimeOfImpact first_time_of_impact(const MovingBody& a, const MovingBody& b, const ImpactTerms& terms);

}  // namespace poise::collision
