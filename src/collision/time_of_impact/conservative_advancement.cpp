// SPDX-License-Identifier: MIT
#include "collision/time_of_impact/conservative_advancement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/triangles/part_descent.h"

namespace poise::collision {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
// Convex parts that only move straight: their nearest points settle in a few rounds.
constexpr int kStraightRounds = 48;
// A gap within the tolerance that loses no more than this share of itself in all the time that is left only slides.
constexpr double kSliding = 0.25;
// Where a hit stands something is nearer than this many tolerances.
constexpr double kNear = 2;
// Turning that carries nothing farther than this share of the tolerance is none: where a hit stands it hardly shows.
constexpr double kNoTurn = 0.1;

// The largest rate of turning that a free body may come to: by its angular momentum and by its energy, whichever bounds
// more.
double largest_rate_radps(const MovingBody& moving_body) {
  const double rate = moving_body.rotation.spin_radps.norm();
  const Vec3& moments = moving_body.moments_kgm2;
  const double least = moments.minCoeff();
  if (rate == 0 || least <= 0 || least == moments.maxCoeff()) return rate;
  const Vec3 spin = moving_body.rotation.orientation.conjugate() * moving_body.rotation.spin_radps;
  const Vec3 momentum = moments.cwiseProduct(spin);
  return std::max(rate, std::min(momentum.norm() / least, std::sqrt(momentum.dot(spin) / least)));
}

// When |p + v t| = r + s t for the first time, 0 where it is already less.
double first_time_s(const Vec3& p, const Vec3& v, double r, double s) {
  const double outside = p.squaredNorm() - r * r;
  if (outside <= 0) return 0;
  const double a = v.squaredNorm() - s * s;
  const double b = p.dot(v) - r * s;
  const double root2 = b * b - a * outside;
  if (root2 < 0 || (a > 0 && b >= 0)) return kNever;
  const double under = std::sqrt(root2) - b;
  return under > 0 ? outside / under : kNever;
}

// A plane in the frame of the descent.
struct StandingPlane {
  Vec3 normal = Vec3::UnitZ();
  double height_m = 0;
};

StandingPlane plane_of(const StandingShape& s) {
  if (s.shape->kind != ShapeKind::Plane) return {};
  const Vec3 normal = s.turn * s.shape->plane_normal;
  return {normal, s.shape->plane_offset_m + normal.dot(s.at_m)};
}

double arm_of(const ConvexPart& part, const Vec3& about) {
  double arm = 0;
  for (const Vec3& corner : part.all()) arm = std::max(arm, (corner - about).norm());
  return arm;
}

// Least distance of the surfaces.
struct GapMeasure {
  StandingPlane plane;
  ConvexGap nearest;
  [[nodiscard]] double best() const { return nearest.gap_m; }
  [[nodiscard]] double of_balls(const BoundingBall& a, const BoundingBall& b) const {
    return (b.center_m - a.center_m).norm() - a.radius_m - b.radius_m;
  }
  [[nodiscard]] double to_plane(const BoundingBall& a) const {
    return plane.normal.dot(a.center_m) - plane.height_m - a.radius_m;
  }
  void keep(const ConvexGap& gap) {
    if (gap.gap_m < nearest.gap_m) nearest = gap;
  }
  void of_parts(const ConvexPart& a, const ConvexPart& b) { keep(gap_of(a, b)); }
  void part_to_plane(const ConvexPart& a) { keep(gap_to_plane(a, plane.normal, plane.height_m)); }
};

// How one body turns during a round.
struct Turning {
  Vec3 about_m = Vec3::Zero();
  Vec3 spin_radps = Vec3::Zero();
  double rate_radps = 0;
  [[nodiscard]] Vec3 velocity_at(const Vec3& point) const { return spin_radps.cross(point - about_m); }
};

// The first time from now at which something may meet. While nothing turns that is when it does.
class TimeMeasure {
 public:
  TimeMeasure(const Vec3& velocity_mps, const Turning& a, const Turning& b, const StandingPlane& plane, double limit_s,
              double tolerance_m)
      : velocity_mps_(velocity_mps),
        a_(a),
        b_(b),
        plane_(plane),
        limit_s_(limit_s),
        tolerance_m_(tolerance_m),
        time_s_(limit_s) {}

  [[nodiscard]] double best() const { return time_s_; }
  [[nodiscard]] bool found() const { return time_s_ < limit_s_; }
  [[nodiscard]] bool hit() const { return hit_; }

  [[nodiscard]] double of_balls(const BoundingBall& a, const BoundingBall& b) const {
    const double reach = a.radius_m + b.radius_m + tolerance_m_;
    const double carried = a_.rate_radps * a.arm_m + b_.rate_radps * b.arm_m;
    const double most = swing(a_, a.arm_m) + swing(b_, b.arm_m);
    const Vec3 p = b.center_m - a.center_m;
    const double early = first_time_s(p, velocity_mps_, reach, carried);
    // However fast it turns, nothing gets farther than to the other side of its centre.
    return carried * limit_s_ > most ? std::max(early, first_time_s(p, velocity_mps_, reach + most, 0)) : early;
  }
  [[nodiscard]] double to_plane(const BoundingBall& a) const {
    const double gap = plane_.normal.dot(a.center_m) - plane_.height_m - a.radius_m - tolerance_m_;
    const double closing = plane_.normal.dot(velocity_mps_);
    return std::max(used_up_s(gap, closing + a_.rate_radps * a.arm_m), used_up_s(gap - swing(a_, a.arm_m), closing));
  }
  void of_parts(const ConvexPart& a, const ConvexPart& b) {
    const double arm_a = arm_of(a, a_.about_m);
    const double arm_b = arm_of(b, b_.about_m);
    const auto gap_at = [&](double time_s) {
      ConvexPart moved = b;
      for (std::size_t k = 0; k < moved.corners; ++k) moved.corner_m[k] += time_s * velocity_mps_;
      return gap_of(a, moved);
    };
    meet(a, arm_a, b.all(), arm_b, gap_at);
  }
  void part_to_plane(const ConvexPart& a) {
    const auto gap_at = [&](double time_s) {
      return gap_to_plane(a, plane_.normal, plane_.height_m + time_s * plane_.normal.dot(velocity_mps_));
    };
    meet(a, arm_of(a, a_.about_m), {}, 0, gap_at);
  }

 private:
  static double used_up_s(double gap_m, double closing_mps) {
    if (gap_m <= 0) return 0;
    return closing_mps > 0 ? gap_m / closing_mps : kNever;
  }
  [[nodiscard]] static double swing(const Turning& t, double arm_m) { return t.rate_radps > 0 ? 2 * arm_m : 0; }

  template <class GapAt>
  void meet(const ConvexPart& a, double arm_a, std::span<const Vec3> corners_b, double arm_b, GapAt&& gap_at) {
    const double carried = a_.rate_radps * arm_a + b_.rate_radps * arm_b;
    if (carried * limit_s_ <= kNoTurn * tolerance_m_) {
      meet_straight(gap_at);
    } else {
      meet_turning(a, arm_a, corners_b, arm_b, carried, gap_at(0.0));
    }
  }

  template <class GapAt>
  void meet_straight(GapAt&& gap_at) {
    double time_s = 0;
    for (int round = 0; round < kStraightRounds; ++round) {
      const ConvexGap gap = gap_at(time_s);
      const double closing = -gap.normal.dot(velocity_mps_);
      if (closing <= 0) return;
      if (gap.gap_m <= tolerance_m_) {
        if (!slides(gap.gap_m, closing)) keep(time_s, true);
        return;
      }
      time_s += (gap.gap_m - 0.5 * tolerance_m_) / closing;
      if (time_s >= time_s_) return;
    }
    keep(time_s, false);
  }

  void meet_turning(const ConvexPart& a, double arm_a, std::span<const Vec3> corners_b, double arm_b, double carried,
                    const ConvexGap& gap) {
    const Vec3& n = gap.normal;
    const double straight = -n.dot(velocity_mps_);
    const double closing = straight + n.dot(a_.velocity_at(gap.point_m) - b_.velocity_at(gap.point_m));
    if (gap.gap_m <= tolerance_m_ && closing > 0 && !slides(gap.gap_m, closing)) {
      keep(0, true);
      return;
    }
    if (gap.gap_m <= 0) return;
    const double slack = gap.gap_m - 0.5 * std::min(gap.gap_m, tolerance_m_);
    // Three bounds, the best of them: by the largest rate; by the present motion of the corners and what it may change,
    // whose second derivative is at most twice arm rate^2; and by how far turning can carry at all.
    const double change = 2 * (a_.rate_radps * a_.rate_radps * arm_a + b_.rate_radps * b_.rate_radps * arm_b);
    double corners_s = kNever;
    for_corners(a_, a.all(), n, [&](double behind_a, double rate_a) {
      for_corners(b_, corners_b, -n, [&](double behind_b, double rate_b) {
        const double way = slack + behind_a + behind_b;
        const double closing_mps = straight + rate_a + rate_b;
        const double under = closing_mps + std::sqrt(closing_mps * closing_mps + 2 * change * way);
        if (under > 0) corners_s = std::min(corners_s, 2 * way / under);
      });
    });
    double time_s = std::max(used_up_s(slack, straight + carried), corners_s);
    time_s = std::max(time_s, used_up_s(slack - swing(a_, arm_a) - swing(b_, arm_b), straight));
    keep(time_s, false);
  }

  // Calls use(behind_m, rate_mps) for corners of a part: how far each is behind the foremost one along `ahead`, and how
  // fast turning carries it ahead. Once, with zeros, for what has none (a half-space).
  template <class Use>
  static void for_corners(const Turning& turning, std::span<const Vec3> corners, const Vec3& ahead, Use&& use) {
    if (corners.empty()) use(0.0, 0.0);
    double foremost_m = -kNever;
    for (const Vec3& corner : corners) foremost_m = std::max(foremost_m, ahead.dot(corner));
    for (const Vec3& corner : corners) use(foremost_m - ahead.dot(corner), ahead.dot(turning.velocity_at(corner)));
  }
  [[nodiscard]] bool slides(double gap_m, double closing_mps) const {
    return closing_mps * limit_s_ <= kSliding * gap_m;
  }

  void keep(double time_s, bool hit) {
    if (time_s >= time_s_) return;
    time_s_ = time_s;
    hit_ = hit;
  }

  Vec3 velocity_mps_;  // of b less that of a
  Turning a_, b_;
  StandingPlane plane_;
  double limit_s_, tolerance_m_;
  double time_s_;
  bool hit_ = false;
};

StandingShape standing(const MovingBody& moving_body, const Vec3& origin_m) {
  return {moving_body.shape, turn_of(moving_body), moving_body.position_m - origin_m};
}

}  // namespace

Mat3 turn_of(const MovingBody& moving_body) {
  return (moving_body.rotation.orientation * moving_body.shape->principal_axes.conjugate()).toRotationMatrix();
}

MovingBody moved_on(const MovingBody& moving_body, double time_s) {
  MovingBody later = moving_body;
  later.position_m += time_s * moving_body.velocity_mps;
  if (moving_body.moments_kgm2.minCoeff() > 0) {
    later.rotation = dynamics::turned_freely(moving_body.rotation, moving_body.moments_kgm2, time_s);
  }
  return later;
}

ConvexGap surface_gap(const MovingBody& a, const MovingBody& b, double limit_m) {
  const Vec3 origin = a.position_m;
  const StandingShape stands_a = standing(a, origin);
  const StandingShape stands_b = standing(b, origin);
  GapMeasure measure{plane_of(stands_b), {limit_m, Vec3::Zero(), Vec3::Zero()}};
  Descent descent(ImpactTerms{}.max_node_pairs);
  const double left = descent.run(stands_a, stands_b, measure);
  // What could not be looked at may be as near as its bound.
  if (left < measure.nearest.gap_m) measure.nearest.gap_m = left;
  measure.nearest.point_m += origin;
  return measure.nearest;
}

TimeOfImpact first_time_of_impact(const MovingBody& a, const MovingBody& b, const ImpactTerms& terms) {
  TimeOfImpact impact;
  impact.a = a;
  impact.b = b;
  Descent descent(terms.max_node_pairs);
  for (std::uint32_t round = 0; round < terms.max_rounds; ++round) {
    const double left_s = terms.duration_s - impact.time_s;
    if (left_s <= 0) return impact;
    const Vec3 origin = impact.a.position_m;
    const StandingShape stands_a = standing(impact.a, origin);
    const StandingShape stands_b = standing(impact.b, origin);
    const auto turning = [](const MovingBody& m, const StandingShape& s) {
      return Turning{s.at_m, m.rotation.spin_radps, largest_rate_radps(m)};
    };
    TimeMeasure measure(impact.b.velocity_mps - impact.a.velocity_mps, turning(impact.a, stands_a),
                        turning(impact.b, stands_b), plane_of(stands_b), left_s, terms.tolerance_m);
    const double unseen_s = descent.run(stands_a, stands_b, measure);
    const bool cut = unseen_s < measure.best();
    if (!cut && !measure.found()) return impact;
    const double step_s = cut ? unseen_s : measure.best();
    impact.a = moved_on(impact.a, step_s);
    impact.b = moved_on(impact.b, step_s);
    impact.time_s += step_s;
    if (cut) break;
    if (!measure.hit()) continue;
    // Which parts are nearest there: several come within the tolerance at nearly the same time, as those beside a side
    // that two triangles share.
    impact.kind = TimeOfImpact::Kind::Hit;
    impact.contact = surface_gap(impact.a, impact.b, kNear * terms.tolerance_m);
    return impact;
  }
  impact.kind = TimeOfImpact::Kind::Cut;
  return impact;
}

}  // namespace poise::collision
