// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "poise/result.h"
#include "poise/scene/scene.h"
#include "scene/generators.h"

namespace poise::io {

/// Makes the bodies of SceneRun::pour. Invariant: each source has at least one shape, and low_m <= high_m.
class Pouring {
 public:
  /// `generated`: all bodies of the generators of `scene`, which `radius_m` (one a shape) and `tray_side_m` belong to.
  Pouring(const Scene& scene, std::span<const GeneratedBody> generated, std::span<const double> radius_m,
          double tray_side_m, std::uint64_t seed);

  /// Whether the scene has bodies that more can be like.
  [[nodiscard]] bool any() const { return !sources_.empty(); }
  /// At most `count` bodies at places where `world` has room for them and where they do not meet each other. They refer
  /// to this. Refused: what a query refuses.
  Result<std::vector<GeneratedBody>> next(const World& world, std::uint64_t count);

 private:
  /// Bodies of a kind, and the box of the centres of mass that they begin in.
  struct Source {
    GeneratedKind kind;
    std::uint64_t bodies = 0;  ///< of the scene: its share of those that are poured
    Vec3 low_m = Vec3::Zero(), high_m = Vec3::Zero();
  };
  /// Of the bodies in the list of the scene.
  void add_listed(const Scene& scene);
  void add(const GeneratedKind& kind, std::uint64_t bodies, const Vec3& low_m, const Vec3& high_m);
  const Source& pick(geometry::Random& random) const;
  /// `reached_m`: how far up the dynamic bodies reach.
  Result<bool> find_place(const World& world, double reached_m, const Source& source, double radius_m,
                          geometry::Random& random, Vec3& center_m) const;

  std::vector<Source> sources_;
  std::vector<double> radius_m_;
  Vec3 gravity_mps2_;
  std::uint64_t seed_;
  std::uint64_t poured_ = 0;  ///< places that were looked for
};

}  // namespace poise::io
