// SPDX-License-Identifier: MIT
#include "collision/triangles/point_list.h"

#include <algorithm>
#include <cmath>

namespace poise::collision {
namespace {

// Of points that span the same up to this share, the one with the least gap is taken, and of these the first in the
// mesh.
constexpr double kClearlyMore = 1e-2;
// Axes in the plane of contact along which the outermost contact points are kept when the list is full.
constexpr std::size_t kAxes = 8;

// Two directions square to a unit one (Frisvad 2012 shows why the least coordinate is the safe one to cross with).
struct Plane {
  Vec3 u, v;
  explicit Plane(const Vec3& normal) {
    Vec3 other = Vec3::UnitX();
    if (std::abs(normal.y()) < std::abs(normal.x())) other = Vec3::UnitY();
    if (std::abs(normal.z()) < std::min(std::abs(normal.x()), std::abs(normal.y()))) other = Vec3::UnitZ();
    u = normal.cross(other).normalized();
    v = normal.cross(u);
  }
};

}  // namespace

bool PointList::better(const FoundPoint& a, const FoundPoint& b) const {
  if (a.gap_m < b.gap_m - tie_m_) return true;
  return a.gap_m < b.gap_m + tie_m_ && a.rank < b.rank;
}

void PointList::add(const FoundPoint& point) {
  least_gap_m_ = std::min(least_gap_m_, point.gap_m);
  for (std::size_t i = 0; i < count_; ++i) {
    FoundPoint& other = point_[i];
    if ((other.point_m - point.point_m).squaredNorm() > merge_m_ * merge_m_) continue;
    if (other.normal.dot(point.normal) < kOneWay) continue;
    const std::uint64_t first = std::min(other.order, point.order);
    if (better(point, other)) other = point;
    other.order = first;
    return;
  }
  if (count_ == kRoom) thin_out();
  point_[count_++] = point;
}

void PointList::remove_below(double gap_m) {
  least_gap_m_ = std::numeric_limits<double>::infinity();
  std::size_t count = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (point_[i].gap_m < gap_m) continue;
    least_gap_m_ = std::min(least_gap_m_, point_[i].gap_m);
    point_[count++] = point_[i];
  }
  count_ = count;
}

bool PointList::overlaps_only_along(const Vec3& normal) const {
  for (std::size_t i = 0; i < count_; ++i) {
    if (point_[i].gap_m < 0 && point_[i].normal.dot(normal) < kOneWay) return false;
  }
  return true;
}

// True if another face is nearer to the same corner.
bool PointList::outdone(std::size_t index) const {
  const FoundPoint& point = point_[index];
  if (point.corner == FoundPoint::kNoCorner || point.in_groove || !(point.gap_m < 0)) return false;
  for (std::size_t i = 0; i < count_; ++i) {
    const FoundPoint& other = point_[i];
    if (other.corner != point.corner || other.in_groove || !(other.gap_m <= 0)) continue;
    if (other.gap_m > point.gap_m + tie_m_) return true;
  }
  return false;
}

void PointList::sort_into(double reach_m, Groups& groups) const {
  std::array<std::uint8_t, kRoom> left;
  std::size_t count = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!(point_[i].gap_m < reach_m) || outdone(i)) continue;
    std::size_t at = count++;
    for (; at > 0 && point_[left[at - 1]].order > point_[i].order; --at) left[at] = left[at - 1];
    left[at] = static_cast<std::uint8_t>(i);
  }
  while (count > 0 && groups.count < kMaxManifoldPoints) {
    std::size_t deepest = 0;
    for (std::size_t k = 1; k < count; ++k) {
      if (point_[left[k]].gap_m < point_[left[deepest]].gap_m - tie_m_) deepest = k;
    }
    Group& group = groups.group[groups.count++];
    group.count = 0;
    group.normal = point_[left[deepest]].normal;
    group.member[group.count++] = left[deepest];
    std::size_t rest = 0;
    for (std::size_t k = 0; k < count; ++k) {
      if (k == deepest) continue;
      if (point_[left[k]].normal.dot(group.normal) >= kOneWay) {
        group.member[group.count++] = left[k];
      } else {
        left[rest++] = left[k];
      }
    }
    count = rest;
  }
}

// Of the points as deep as the deepest: the one farthest from the middle of all, so that the rest can span from it.
std::size_t PointList::outermost_of_deepest(const Group& group) const {
  const auto found = [&](std::size_t k) -> const FoundPoint& { return point_[group.member[k]]; };
  Vec3 middle = Vec3::Zero();
  for (std::size_t k = 0; k < group.count; ++k) middle += found(k).point_m;
  middle /= static_cast<double>(group.count);
  std::size_t best = 0;
  double farthest2 = (found(0).point_m - middle).squaredNorm();
  for (std::size_t k = 1; k < group.count; ++k) {
    const double there2 = (found(k).point_m - middle).squaredNorm();
    if (found(k).gap_m > found(0).gap_m + tie_m_ || !(there2 > farthest2 * (1 + kClearlyMore))) continue;
    best = k;
    farthest2 = there2;
  }
  return best;
}

// How much a length to a member counts: half where it is farther off than the deepest, or than what touches, by the
// merging distance. If it counted in full, a place that hangs over the other body could take the place of one that
// carries it, and a body at rest would rock between the two.
double PointList::weight(const Group& group, std::size_t k) const {
  const double touching_m = std::max(0.0, point_[group.member[0]].gap_m);
  return merge_m_ / (merge_m_ + std::max(0.0, point_[group.member[k]].gap_m - touching_m));
}

std::size_t PointList::pick(const Group& group, std::size_t most,
                            std::array<std::uint8_t, kMaxManifoldPoints>& out) const {
  const auto at = [&](std::size_t k) -> const Vec3& { return point_[group.member[k]].point_m; };
  std::size_t count = 0;
  std::array<Vec3, kMaxManifoldPoints> chosen;
  const auto take = [&](std::size_t k) {
    chosen[count] = at(k);
    out[count++] = group.member[k];
  };
  const auto gap = [&](std::size_t k) { return point_[group.member[k]].gap_m; };
  // The member with the largest figure by its weight, of those with a figure above `least`; none where there is no
  // such.
  const auto largest = [&](double least, auto&& figure) {
    std::size_t best = group.count;
    double most_yet = 0;
    for (std::size_t k = 0; k < group.count; ++k) {
      double there = figure(at(k));
      if (!(there > least)) continue;
      there *= weight(group, k);
      const bool clearly = best == group.count || there > most_yet * (1 + kClearlyMore);
      if (!clearly && !(there > most_yet * (1 - kClearlyMore) && gap(k) < gap(best) - tie_m_)) continue;
      best = k;
      most_yet = std::max(most_yet, there);
    }
    return best;
  };
  take(outermost_of_deepest(group));
  if (most < 2) return count;
  const std::size_t second =
      largest(merge_m_, [&](const Vec3& p) { return (p - chosen[0]).cross(group.normal).norm(); });
  if (second == group.count) return count;
  take(second);
  if (most < 3) return count;
  // Twice areas. Points that make no triangle higher than the merging distance add nothing.
  const Vec3 base = chosen[1] - chosen[0];
  const double thin = merge_m_ * base.norm();
  const std::size_t third =
      largest(thin, [&](const Vec3& p) { return std::abs(group.normal.dot(base.cross(p - chosen[0]))); });
  if (third == group.count) return count;
  take(third);
  if (most < 4) return count;
  const double turn = group.normal.dot(base.cross(chosen[2] - chosen[0])) > 0 ? 1.0 : -1.0;
  const std::size_t fourth = largest(thin, [&](const Vec3& p) {
    double outside = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& from = chosen[i];
      outside = std::max(outside, -turn * group.normal.dot((chosen[(i + 1) % 3] - from).cross(p - from)));
    }
    return outside;
  });
  if (fourth != group.count) take(fourth);
  return count;
}

ManifoldPoints PointList::choose(double reach_m) const {
  Groups groups;
  sort_into(reach_m, groups);
  std::array<std::size_t, kMaxManifoldPoints> share{};
  std::size_t given = groups.count;
  std::fill_n(share.begin(), groups.count, std::size_t{1});
  for (bool more = true; more && given < kMaxManifoldPoints;) {
    more = false;
    for (std::size_t g = 0; g < groups.count && given < kMaxManifoldPoints; ++g) {
      if (share[g] == groups.group[g].count) continue;
      ++share[g];
      ++given;
      more = true;
    }
  }
  ManifoldPoints set;
  for (std::size_t g = 0; g < groups.count; ++g) {
    std::array<std::uint8_t, kMaxManifoldPoints> picked;
    const std::size_t count = pick(groups.group[g], share[g], picked);
    for (std::size_t k = 0; k < count; ++k) {
      const FoundPoint& point = point_[picked[k]];
      set.point[set.count++] = {point.normal, point.point_m, point.gap_m, point.gap_m};
    }
  }
  return set;
}

void PointList::thin_out() {
  Groups groups;
  sort_into(std::numeric_limits<double>::infinity(), groups);
  std::array<bool, kRoom> keep{};
  for (std::size_t g = 0; g < groups.count; ++g) {
    const Group& group = groups.group[g];
    const Plane plane(group.normal);
    keep[group.member[0]] = true;
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      // Eight axes evenly around; the diagonal ones need not be unit.
      constexpr std::array<std::array<double, 2>, kAxes> kToward = {
          {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
      const Vec3 toward = kToward[axis][0] * plane.u + kToward[axis][1] * plane.v;
      std::size_t best = 0;
      double farthest = 0;
      for (std::size_t k = 1; k < group.count; ++k) {
        const Vec3 from_deepest = point_[group.member[k]].point_m - point_[group.member[0]].point_m;
        const double there = weight(group, k) * toward.dot(from_deepest);
        if (!(there > farthest)) continue;
        best = k;
        farthest = there;
      }
      keep[group.member[best]] = true;
    }
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (keep[i]) point_[count++] = point_[i];
  }
  count_ = count;
}

}  // namespace poise::collision
