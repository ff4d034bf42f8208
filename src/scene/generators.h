// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "poise/scene/scene.h"

namespace poise::io {

/// A body that a generator makes.
struct GeneratedBody {
  std::size_t shape = 0;
  const GeneratedKind* kind = nullptr;  ///< of its generator
  Vec3 center_m = Vec3::Zero();         ///< centre of mass
  Quat orientation = Quat::Identity();
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 angular_velocity_radps = Vec3::Zero();
  bool streamed = false;
  double due_s = 0;  ///< of a stream body
};

struct ExpandOptions {
  std::optional<std::uint64_t> bodies;  ///< of all generators together
  std::uint64_t seed = 1;               ///< of the scene
  std::span<const double> radius_m;     ///< bounding radius of each shape about its centre of mass
  double tray_side_m = 0;
};

/// `total` shared out in proportion to `own` (each at least 1), rounded down, the rest one each to the first ones.
std::vector<std::uint64_t> share_bodies(std::span<const std::uint64_t> own, std::uint64_t total);

/// Side of the tray for `generated` bodies, 0 without a tray. A side that follows from the number of bodies is at least
/// what one body needs. `radius_m` as in ExpandOptions.
double tray_side_m(const Scene& scene, std::uint64_t generated, std::span<const double> radius_m);

/// All generated bodies: those of the start in generator order, then the streamed ones by due time (ties: generator
/// order). Body k of a generator is the same whatever the number of bodies, where its place does not depend on it.
/// Refused: a tray that is too small for one body. The result points into `scene`.
Result<std::vector<GeneratedBody>> expand_generators(const Scene& scene, const ExpandOptions& options);

}  // namespace poise::io
