// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/cover/sphere_patches.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "math/functions.h"

namespace poise::geometry {
namespace {

// Chosen by trials: smaller values take longer, see docs/sphere-trees.md.
constexpr double kMaxWithin = 0.02;
constexpr double kMeanWithin = 0.05;
constexpr std::size_t kMaxPatches = 6000;
constexpr int kMostRounds = 24;
/// Patches with a smaller angle from middle to corner are not cut; 1e-5 of the radius.
constexpr double kSmallestReach_rad = 1e-5;
/// Angles and their cosines are computed in double; all decisions here use a tolerance larger than the error.
constexpr double kSlack = 1e-11;

/// Directions with x . axis > cosine are inside another sphere.
struct Cap {
  Vec3 axis;
  double cosine;
};

/// A spherical triangle of directions from the sphere's centre, smaller than an octant, and bounds of the distance in
/// it.
struct SurfacePatch {
  std::array<Vec3, 3> corners;
  Vec3 middle;
  double cos_reach = 1;       ///< cosine of the angle from the middle to the farthest corner
  double area = 0;            ///< in steradians
  std::size_t first_cap = 0;  ///< caps that it overlaps, in SpherePatches::met_
  std::size_t cap_count = 0;  ///< 0: the whole patch is exposed
  double max_m = 0;           ///< upper bound of the distance
  double mean_m = 0;          ///< upper bound of the mean over the patch, and over any part of it if the patch overlaps
                              ///< a cap
  double seen_m = 0;          ///< the distance at one point
  bool exposed_seen = false;  ///< that point is exposed
  std::uint32_t piece = TriangleBvh::kNoTriangle;
};

/// An upper bound of x . way over a patch. A direction in the patch is a convex combination of the corners, divided by
/// a length from cos_reach to 1.
double most_along(const SurfacePatch& patch, const Vec3& way) {
  const double most = std::max({patch.corners[0].dot(way), patch.corners[1].dot(way), patch.corners[2].dot(way)});
  return most > 0 ? most / patch.cos_reach : most;
}

/// Area of a spherical triangle (Van Oosterom and Strackee 1983).
double solid_angle(const std::array<Vec3, 3>& v) {
  return 2 * math::atan2(v[0].dot(v[1].cross(v[2])), 1 + v[0].dot(v[1]) + v[1].dot(v[2]) + v[2].dot(v[0]));
}

/// Integral of the direction over a spherical triangle: half the sum over its arcs of angle times unit normal of the
/// arc's plane.
Vec3 direction_integral(const std::array<Vec3, 3>& v) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 across = v[i].cross(v[(i + 1) % 3]);
    const double s2 = across.squaredNorm();
    // angle / sine of the angle; the series is accurate to 1e-9 below 0.1.
    const double ratio = s2 < 0.01 ? 1 + s2 * (1.0 / 6 + s2 * (3.0 / 40 + s2 * (15.0 / 336)))
                                   : math::atan2(std::sqrt(s2), v[i].dot(v[(i + 1) % 3])) / std::sqrt(s2);
    sum += 0.5 * ratio * across;
  }
  return sum;
}

/// Patches of one sphere that are not completely hidden. Invariant: patches and hidden parts make up the whole sphere.
class SpherePatches {
 public:
  SpherePatches(const Sphere& own, std::span<const Sphere> others, const ObjectQueries& object, double tolerance_m)
      : own_(own), object_(object), tolerance_m_(tolerance_m) {
    for (const Sphere& other : others) add_cap(other);
    if (wholly_hidden_) return;
    met_.resize(caps_.size());
    std::iota(met_.begin(), met_.end(), 0U);
    for (unsigned octant = 0; octant < 8; ++octant) {
      const std::array<double, 3> sign{(octant & 1U) != 0 ? -1.0 : 1.0, (octant & 2U) != 0 ? -1.0 : 1.0,
                                       (octant & 4U) != 0 ? -1.0 : 1.0};
      std::array<Vec3, 3> corners{sign[0] * Vec3::UnitX(), sign[1] * Vec3::UnitY(), sign[2] * Vec3::UnitZ()};
      if (sign[0] * sign[1] * sign[2] < 0) std::swap(corners[1], corners[2]);
      cut(corners, 2, 0, caps_.size(), TriangleBvh::kNoTriangle);
    }
  }

  SphereProtrusion refine() {
    for (int round = 0; round < kMostRounds && patches_.size() < kMaxPatches; ++round) {
      const std::vector<std::uint8_t> chosen = choose();
      if (std::ranges::find(chosen, 1) == chosen.end()) break;
      const std::vector<SurfacePatch> old = std::move(patches_);
      patches_.clear();
      for (std::size_t i = 0; i < old.size(); ++i) {
        if (chosen[i] == 0) {
          patches_.push_back(old[i]);
        } else {
          cut(old[i].corners, 1, old[i].first_cap, old[i].cap_count, old[i].piece);
        }
      }
    }
    SphereProtrusion result{largest_bound(), mean_bound()};
    result.mean_m = std::min(result.mean_m, result.max_m);
    return result;
  }

 private:
  void add_cap(const Sphere& other) {
    const Vec3 toward = other.center_m - own_.center_m;
    const double apart = toward.norm();
    if (apart + own_.radius_m < other.radius_m * (1 - kSlack)) wholly_hidden_ = true;
    if (!(apart > 0)) return;
    const double squares = own_.radius_m * own_.radius_m + apart * apart - other.radius_m * other.radius_m;
    const double cosine = squares / (2 * own_.radius_m * apart);
    // The error of the cosine grows when the centres are close.
    const double slack = kSlack * (1 + (own_.radius_m + other.radius_m) / apart);
    if (cosine + slack < 1) caps_.push_back({toward / apart, cosine + slack});
  }

  /// Adds a triangle, subdivided into four `times` times, without hidden parts.
  void cut(const std::array<Vec3, 3>& corners, int times, std::size_t first_cap, std::size_t cap_count,
           std::uint32_t guess) {
    if (times == 0) {
      add(corners, first_cap, cap_count, guess);
      return;
    }
    const Vec3 a = (corners[0] + corners[1]).normalized();
    const Vec3 b = (corners[1] + corners[2]).normalized();
    const Vec3 c = (corners[2] + corners[0]).normalized();
    cut({corners[0], a, c}, times - 1, first_cap, cap_count, guess);
    cut({a, corners[1], b}, times - 1, first_cap, cap_count, guess);
    cut({c, b, corners[2]}, times - 1, first_cap, cap_count, guess);
    cut({a, b, c}, times - 1, first_cap, cap_count, guess);
  }

  [[nodiscard]] bool exposed(const SurfacePatch& patch, const Vec3& direction) const {
    for (std::size_t i = patch.first_cap; i < patch.first_cap + patch.cap_count; ++i) {
      const Cap& cap = caps_[met_[i]];
      if (direction.dot(cap.axis) > cap.cosine) return false;
    }
    return true;
  }

  /// Whether a patch lies completely in a cap. A cap up to half a sphere is convex; for a larger one the circle around
  /// the patch is tested.
  static bool hidden_by(const Cap& cap, const SurfacePatch& patch) {
    if (cap.cosine >= 0) {
      return std::ranges::all_of(patch.corners, [&](const Vec3& corner) { return corner.dot(cap.axis) > cap.cosine; });
    }
    const double along = patch.middle.dot(cap.axis);
    const double across = std::sqrt(std::max(0.0, 1 - along * along));
    const double sin_reach = std::sqrt(std::max(0.0, 1 - patch.cos_reach * patch.cos_reach)) + kSlack;
    // The angle to the axis plus the patch's reach must stay below half a turn and in the cap.
    return along > -patch.cos_reach && along * patch.cos_reach - across * sin_reach > cap.cosine + kSlack;
  }

  void add(const std::array<Vec3, 3>& corners, std::size_t first_cap, std::size_t cap_count, std::uint32_t guess) {
    SurfacePatch patch;
    patch.corners = corners;
    patch.middle = (corners[0] + corners[1] + corners[2]).normalized();
    patch.cos_reach =
        std::min({corners[0].dot(patch.middle), corners[1].dot(patch.middle), corners[2].dot(patch.middle)}) *
        (1 - 1e-15);
    patch.first_cap = met_.size();
    for (std::size_t i = first_cap; i < first_cap + cap_count; ++i) {
      const std::uint32_t index = met_[i];
      const Cap& cap = caps_[index];
      if (hidden_by(cap, patch)) {
        met_.resize(patch.first_cap);
        return;
      }
      if (most_along(patch, cap.axis) >= cap.cosine - kSlack) met_.push_back(index);
    }
    patch.cap_count = met_.size() - patch.first_cap;
    patch.area = solid_angle(corners);
    bound(patch, guess);
    if (patch.exposed_seen) seen_m_ = std::max(seen_m_, patch.seen_m);
    patches_.push_back(patch);
  }

  void bound(SurfacePatch& patch, std::uint32_t guess) const {
    Vec3 at = patch.middle;
    patch.exposed_seen = exposed(patch, at);
    for (std::size_t i = 0; i < 3 && !patch.exposed_seen; ++i) {
      if (!exposed(patch, patch.corners[i])) continue;
      at = patch.corners[i];
      patch.exposed_seen = true;
    }
    const Vec3 point = own_.center_m + own_.radius_m * at;
    const ObjectBall ball = object_.nearest(point, guess);
    patch.piece = ball.piece;
    patch.seen_m = std::max(0.0, (point - ball.center_m).norm() - ball.radius_m);
    // Bounds of the distance to the ball's centre: largest, smallest, and the root of the mean of its square (Jensen's
    // inequality).
    const Vec3 from = own_.center_m - ball.center_m;
    const double squares = own_.radius_m * own_.radius_m + from.squaredNorm();
    const auto distance_m = [&](double along) { return std::sqrt(std::max(0.0, squares + 2 * own_.radius_m * along)); };
    const double length = from.norm();
    const double least_m = distance_m(std::max(-length, -most_along(patch, -from))) - ball.radius_m;
    const double mean_m = distance_m(from.dot(direction_integral(patch.corners)) / patch.area) - ball.radius_m;
    patch.max_m = std::max(0.0, distance_m(std::min(length, most_along(patch, from))) - ball.radius_m);
    // Where a part of the patch is inside the ball, the mean counts negative distances as 0.
    patch.mean_m = std::min(patch.max_m, mean_m + std::max(0.0, -least_m));
    if (patch.max_m > 0 && patch.piece != TriangleBvh::kNoTriangle) bound_by_piece(patch);
    if (patch.cap_count > 0) patch.mean_m = patch.max_m;
  }

  /// The distance to a convex piece is convex. Over the flat triangle of the corners it is at most the linear
  /// interpolation of the corners' distances, and the sphere is within the sagitta of the triangle. Seen from the
  /// centre, the weights in the flat triangle are accurate within cos_reach^3.
  void bound_by_piece(SurfacePatch& patch) const {
    double most = 0;
    double least = std::numeric_limits<double>::infinity();
    double sum = 0;
    for (const Vec3& corner : patch.corners) {
      const double distance_m = object_.to_piece(patch.piece, own_.center_m + own_.radius_m * corner);
      most = std::max(most, distance_m);
      least = std::min(least, distance_m);
      sum += distance_m;
    }
    const double sagitta_m = own_.radius_m * (1 - patch.cos_reach);
    patch.max_m = std::min(patch.max_m, most + sagitta_m);
    const double weight = 1 / (patch.cos_reach * patch.cos_reach * patch.cos_reach);
    patch.mean_m = std::min(patch.mean_m, least + (sum / 3 - least) * weight + sagitta_m);
  }

  [[nodiscard]] double largest_bound() const {
    double largest_m = 0;
    for (const SurfacePatch& patch : patches_) largest_m = std::max(largest_m, patch.max_m);
    return largest_m;
  }

  /// The largest mean for any hidden shares of the patches that overlap a cap: patches above the mean count completely,
  /// the others not at all.
  [[nodiscard]] double mean_bound() const {
    std::vector<std::pair<double, double>> partly;  // mean, area
    double sum = 0;
    double area = 0;
    for (const SurfacePatch& patch : patches_) {
      if (patch.cap_count > 0) {
        partly.emplace_back(patch.mean_m, patch.area);
      } else {
        sum += patch.mean_m * patch.area;
        area += patch.area;
      }
    }
    std::ranges::sort(partly, std::greater<>());  // equal entries are interchangeable
    for (const auto& [mean_m, share] : partly) {
      if (area > 0 && mean_m * area <= sum) break;
      sum += mean_m * share;
      area += share;
    }
    return area > 0 ? sum / area : 0;
  }

  /// Selects the patches to cut next: 1 for selected ones.
  [[nodiscard]] std::vector<std::uint8_t> choose() const {
    std::vector<std::uint8_t> chosen(patches_.size(), 0);
    const double smallest_cosine = math::cos(kSmallestReach_rad);
    const double enough_m = std::max(seen_m_ * (1 + kMaxWithin), seen_m_ + tolerance_m_);
    // Patches with the largest bounds come first: they may show a distance that decides the others.
    const double from_m = enough_m + 0.3 * std::max(0.0, largest_bound() - enough_m);
    double sum = 0;
    double area = 0;
    for (const SurfacePatch& patch : patches_) {
      const double share = patch.area * (patch.cap_count == 0 ? 1.0 : patch.exposed_seen ? 0.5 : 0.0);
      sum += patch.seen_m * share;
      area += share;
    }
    const double mean_m = area > 0 ? sum / area : 0;
    // The error of the mean that a patch may add, negative so that the largest comes first.
    std::vector<std::pair<double, std::size_t>> gaps;
    double gap_sum = 0;
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      const SurfacePatch& patch = patches_[i];
      if (patch.cos_reach > smallest_cosine) continue;
      if (patch.max_m > enough_m && patch.max_m >= from_m) chosen[i] = 1;
      double gap = patch.mean_m - patch.seen_m;
      if (patch.cap_count > 0)
        gap = 0.5 * std::max(std::abs(patch.seen_m - mean_m), std::max(0.0, patch.mean_m - mean_m));
      gaps.emplace_back(-gap * patch.area, i);
      gap_sum += gap * patch.area;
    }
    double rest = std::max(kMeanWithin * mean_m, 0.5 * tolerance_m_) * std::max(area, 1e-9);
    if (gap_sum <= rest) return chosen;
    std::ranges::sort(gaps);
    rest *= 0.5;
    for (const auto& [gap, i] : gaps) {
      if (gap_sum <= rest) break;
      chosen[i] = 1;
      gap_sum += gap;
    }
    return chosen;
  }

  Sphere own_;
  const ObjectQueries& object_;
  double tolerance_m_;
  bool wholly_hidden_ = false;
  double seen_m_ = 0;
  std::vector<Cap> caps_;
  std::vector<std::uint32_t> met_;
  std::vector<SurfacePatch> patches_;
};

}  // namespace

SphereProtrusion sphere_protrusion(const Sphere& own, std::span<const Sphere> others, const ObjectQueries& object,
                                   double tolerance_m) {
  return SpherePatches(own, others, object, tolerance_m).refine();
}

}  // namespace poise::geometry
