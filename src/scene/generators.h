// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "geometry/primitives/random.h"
#include "poise/scene/scene.h"

namespace poise::io {

/// A generated body.
struct GeneratedBody {
  std::size_t shape = 0;
  const GeneratedKind* kind = nullptr;  ///< of its generator
  Vec3 center_m = Vec3::Zero();         ///< of mass
  Quat orientation = Quat::Identity();
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 angular_velocity_radps = Vec3::Zero();
  bool is_static = false;
  bool streamed = false;
  double due_s = 0;  ///< for a stream body, seconds
  double leaves_s = std::numeric_limits<double>::infinity();
};

/// Without shape and material, which a World names. The World takes the position of the shape's origin, generators give
/// that of the centre of mass.
BodyDefinition definition_of(const GeneratedBody& body, const Shape& shape);

struct ExpandOptions {
  std::optional<std::uint64_t> bodies;  ///< number for all generators together
  std::uint64_t seed = 1;               ///< of the scene
  std::span<const double> radius_m;     ///< bounding radius of each shape about its centre of mass
  double tray_side_m = 0;
};

/// Everything of a generated body but its position, drawn in a fixed order from a generator of its own; `index` counts
/// the bodies of the kind.
GeneratedBody draw_body(const GeneratedKind& kind, std::uint64_t index, geometry::Random& random);

/// Divides `total` in proportion to `own` (each at least 1), rounded down; the remainder goes one each to the first
/// ones.
std::vector<std::uint64_t> share_bodies(std::span<const std::uint64_t> own, std::uint64_t total);

/// How many bodies each generator makes: its own count, or its share of `bodies`.
std::vector<std::uint64_t> generated_counts(const Scene& scene, std::optional<std::uint64_t> bodies);

/// Side of the tray for `generated` bodies, metres; 0 without a tray. A side that depends on the number of bodies is at
/// least the size needed for one body. `radius_m` as in ExpandOptions.
double tray_side_m(const Scene& scene, std::uint64_t generated, std::span<const double> radius_m);

/// All generated bodies: those of the start in generator order, then the stream bodies by due time (ties: generator
/// order). Body k of a generator is the same for any number of bodies, unless its position depends on that number.
/// Refused: a tray that is too small for one body. The result refers to `scene`.
Result<std::vector<GeneratedBody>> expand_generators(const Scene& scene, const ExpandOptions& options);

/// The largest number of these bodies that are there at once, by their times.
std::uint64_t most_at_once(std::span<const GeneratedBody> bodies);

}  // namespace poise::io
