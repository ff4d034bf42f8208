// SPDX-License-Identifier: MIT
#include "scene/pouring.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <variant>

namespace poise::io {
namespace {

using geometry::Random;

/// A body is poured with this much room around it, relative to its bounding radius. Chosen.
constexpr double kRoom = 1.05;
/// How far above what it falls on it begins, in bounding radii. Chosen: far enough to be seen falling.
constexpr double kDrop = 4;
/// How far around bodies of a list more are poured, in bounding radii. Chosen.
constexpr double kAround = 5;
/// Places that are tried for a body. Chosen.
constexpr int kTries = 8;

/// Apart from the seeds of generators.
constexpr std::uint64_t kPouringSeed = 0x706f7572;

struct Poured {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
};

bool meets(const std::vector<Poured>& others, const Vec3& center_m, double radius_m) {
  return std::ranges::any_of(others, [&](const Poured& other) {
    return (other.center_m - center_m).norm() < kRoom * (other.radius_m + radius_m);
  });
}

/// How far the dynamic bodies reach along a direction, metres from the origin.
double reach_m(const World& world, const Vec3& up) {
  double most_m = -std::numeric_limits<double>::infinity();
  for (const BodyId body : world.bodies()) {
    if (world.motion_type(body).value() != MotionType::Dynamic) continue;
    most_m =
        std::max(most_m, world.state(body).value().position_m.dot(up) + world.shape(body).value()->bounding_radius_m);
  }
  return most_m;
}

}  // namespace

Pouring::Pouring(const Scene& scene, std::span<const GeneratedBody> generated, std::span<const double> radius_m,
                 double tray_side_m, std::uint64_t seed)
    : radius_m_(radius_m.begin(), radius_m.end()), gravity_mps2_(scene.gravity_mps2), seed_(seed ^ kPouringSeed) {
  for (const SceneGenerator& generator : scene.generators) {
    const auto* grid = std::get_if<GridGenerator>(&generator);
    if (grid != nullptr && grid->is_static) continue;
    const auto* stream = std::get_if<StreamGenerator>(&generator);
    if (grid == nullptr && stream == nullptr) continue;
    const GeneratedKind& kind = grid != nullptr ? grid->kind : stream->kind;
    const double infinite = std::numeric_limits<double>::infinity();
    Vec3 low_m = Vec3::Constant(infinite), high_m = Vec3::Constant(-infinite);
    std::uint64_t bodies = 0;
    for (const GeneratedBody& body : generated) {
      if (body.kind != &kind) continue;
      ++bodies;
      low_m = low_m.cwiseMin(body.center_m);
      high_m = high_m.cwiseMax(body.center_m);
    }
    if (bodies == 0) continue;
    if (stream != nullptr) {
      low_m = stream->region_min_m;
      high_m = stream->region_max_m;
    } else if (grid->in_tray) {
      double widest_m = 0;
      for (const std::size_t shape : kind.shapes) widest_m = std::max(widest_m, radius_m_[shape]);
      const double half_m = std::max(0.0, 0.5 * tray_side_m - kRoom * widest_m);
      low_m.head<2>().setConstant(-half_m);
      high_m.head<2>().setConstant(half_m);
    }
    add(kind, bodies, low_m, high_m);
  }
  if (!any()) add_listed(scene);
}

void Pouring::add_listed(const Scene& scene) {
  Vec3 low_m = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high_m = -low_m;
  for (const SceneBody& body : scene.bodies) {
    if (body.definition.motion != MotionType::Dynamic) continue;
    GeneratedKind kind;
    kind.shapes = {body.shape};
    kind.material = body.material;
    kind.random_orientation = true;
    kind.group = body.definition.group;
    kind.collides_with = body.definition.collides_with;
    kind.importance = body.definition.importance;
    const Vec3 around_m = Vec3::Constant(kAround * radius_m_[body.shape]);
    low_m = low_m.cwiseMin(body.definition.position_m - around_m);
    high_m = high_m.cwiseMax(body.definition.position_m + around_m);
    add(kind, 1, low_m, high_m);
  }
  for (Source& source : sources_) {
    source.low_m = low_m;
    source.high_m = high_m;
  }
}

void Pouring::add(const GeneratedKind& kind, std::uint64_t bodies, const Vec3& low_m, const Vec3& high_m) {
  sources_.push_back({kind, bodies, low_m, high_m});
}

const Pouring::Source& Pouring::pick(Random& random) const {
  std::uint64_t sum = 0;
  for (const Source& source : sources_) sum += source.bodies;
  std::uint64_t at = random.below(std::max<std::uint64_t>(sum, 1));
  for (const Source& source : sources_) {
    if (at < source.bodies) return source;
    at -= source.bodies;
  }
  return sources_.back();
}

Result<bool> Pouring::find_place(const World& world, double reached_m, const Source& source, double radius_m,
                                 Random& random, Vec3& center_m) const {
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    center_m[axis] = source.low_m[axis] + (source.high_m[axis] - source.low_m[axis]) * random.unit();
  if (gravity_mps2_.squaredNorm() > 0) {
    // From above all that moves down to what it would rest on; every point of this way is free.
    const Vec3 up = -gravity_mps2_.normalized();
    const double begins_m = std::max(source.low_m.dot(up), source.high_m.dot(up));
    const double top_m = std::max(reached_m, begins_m);
    SphereCast cast;
    cast.radius_m = kRoom * radius_m;
    cast.center_m = center_m + (top_m + (kDrop + 2) * radius_m - center_m.dot(up)) * up;
    cast.direction = -up;
    const Result<std::optional<SphereCastHit>> hit = world.cast_sphere(cast);
    if (!hit) return hit.error();
    if (!hit.value() || !hit.value()->overlaps_at_start) {
      const double end_m = hit.value() ? hit.value()->distance_m - kDrop * radius_m : top_m - begins_m;
      center_m = cast.center_m - std::max(0.0, end_m) * up;
      return true;
    }
    // Something lies above, as the lid of a box: a free place among those of the start.
  }
  std::vector<BodyId> found;
  const Status looked = world.overlap_sphere(center_m, kRoom * radius_m, found);
  if (!looked) return looked.error();
  return found.empty();
}

Result<std::vector<GeneratedBody>> Pouring::next(const World& world, std::uint64_t count) {
  std::vector<GeneratedBody> bodies;
  if (sources_.empty()) return bodies;
  std::vector<Poured> poured;
  const double reached_m = gravity_mps2_.squaredNorm() > 0 ? reach_m(world, -gravity_mps2_.normalized()) : 0;
  int failed = 0;
  while (bodies.size() < count && failed < kTries) {
    Random random = Random::of(seed_, poured_);
    const Source& source = pick(random);
    GeneratedBody body = draw_body(source.kind, poured_, random);
    ++poured_;
    const double radius_m = radius_m_[body.shape];
    const Result<bool> found = find_place(world, reached_m, source, radius_m, random, body.center_m);
    if (!found) return found.error();
    if (!found.value() || meets(poured, body.center_m, radius_m)) {
      ++failed;
      continue;
    }
    failed = 0;
    poured.push_back({body.center_m, radius_m});
    bodies.push_back(body);
  }
  return bodies;
}

}  // namespace poise::io
