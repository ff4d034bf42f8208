// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/generators.h"

namespace poise::io {

/// A shape with the data for the checks.
struct CheckedShape {
  ShapePtr shape;               ///< for a mesh whose tree is not built yet: with the root alone
  bool to_build = false;        ///< a tree must be built
  std::uint64_t triangles = 0;  ///< of a mesh
  /// The balls or points that reach farthest in each of some directions, in the body frame; empty for planes.
  std::vector<Sphere> outline;
  Vec3 size_m = Vec3::Zero();  ///< edges of the box around it, along the axes of the body frame
};

/// Balls or points of an object, in its body frame, that reach farthest in 256 directions. They give the depth in a
/// plane with an error below 2 % of the object's size.
std::vector<Sphere> outline_of(std::span<const Sphere> parts);

/// A body at its start.
struct PlacedBody {
  std::string path;       ///< `bodies[3]` or `generators[0].grid`
  std::size_t shape = 0;  ///< index into Scene::shapes
  Vec3 center_m = Vec3::Zero();
  Quat orientation = Quat::Identity();
  Vec3 velocity_mps = Vec3::Zero();
  double radius_m = 0;
  std::uint32_t group = 1, collides_with = 0xffffffffU;
  bool is_static = false;
  bool plane = false;
  bool streamed = false;  ///< added later by a stream
};

/// A pair that overlaps at the start, with its penetration depth in metres.
struct DeepPair {
  std::size_t a = 0, b = 0;  ///< indices of bodies
  double depth_m = 0;
};

/// The pairs that overlap deeply at the start, at most `most`, in the order of `a`. Balls: by more than a tenth of the
/// smaller radius. Other shapes, whose bounding spheres may overlap: centres of mass nearer than a quarter of the
/// smaller bounding radius. Planes: a centre of mass below the surface, or a depth of a tenth of the bounding radius.
std::vector<DeepPair> deep_pairs(std::span<const PlacedBody> bodies, std::span<const CheckedShape> shapes,
                                 std::size_t most);

/// Whether any part of a bounding sphere is in the camera's view.
bool in_view(const View& view, const Vec3& center_m, double radius_m);

}  // namespace poise::io
