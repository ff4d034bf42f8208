// SPDX-License-Identifier: MIT
#include "query/checks.h"

#include <fmt/format.h>

#include <cmath>

namespace poise::query {
namespace {

std::optional<Error> check_direction(const Vec3& d) {
  if (d.allFinite() && !d.isZero(0)) return std::nullopt;
  return bad_input(fmt::format("direction = [{}, {}, {}], must be finite and not zero", d.x(), d.y(), d.z()));
}

}  // namespace

std::optional<Error> check_point(const char* field, const Vec3& p) {
  if (p.allFinite() && p.cwiseAbs().maxCoeff() <= kMaxLengthM) return std::nullopt;
  return bad_input(fmt::format("{} = [{}, {}, {}], each must be finite and within {} of zero", field, p.x(), p.y(),
                               p.z(), kMaxLengthM));
}

std::optional<Error> check_length(const char* field, double length_m) {
  if (length_m >= 0 && length_m <= kMaxLengthM) return std::nullopt;
  return bad_input(fmt::format("{} = {}, must be in [0, {}]", field, length_m, kMaxLengthM));
}

std::optional<Error> check_distance(double max_distance_m) {
  if (max_distance_m >= 0) return std::nullopt;
  return bad_input(fmt::format("max_distance_m = {}, must be >= 0", max_distance_m));
}

std::optional<Error> check(const Ray& ray) {
  if (auto bad = check_point("origin_m", ray.origin_m)) return bad;
  if (auto bad = check_direction(ray.direction)) return bad;
  return check_distance(ray.max_distance_m);
}

std::optional<Error> check(const SphereCast& cast) {
  if (auto bad = check_point("center_m", cast.center_m)) return bad;
  if (auto bad = check_length("radius_m", cast.radius_m)) return bad;
  if (auto bad = check_direction(cast.direction)) return bad;
  return check_distance(cast.max_distance_m);
}

std::optional<Error> check(const OrientedBox& box) {
  if (auto bad = check_point("center_m", box.center_m)) return bad;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (auto bad = check_length("half_extents_m", box.half_extents_m[axis])) return bad;
  }
  const Quat& q = box.orientation;
  if (std::isfinite(q.norm()) && q.norm() > 1e-9) return std::nullopt;
  return bad_input(fmt::format("orientation_wxyz = [{}, {}, {}, {}], must be finite, with a norm above 1e-9", q.w(),
                               q.x(), q.y(), q.z()));
}

}  // namespace poise::query
