// SPDX-License-Identifier: MIT
#include "geometry/mesh/procedural.h"

#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "math/functions.h"

namespace poise::geometry {
namespace {

using std::numbers::pi;
using Index = std::uint32_t;
using Point2 = Eigen::Vector2d;

Index add_vertex(TriangleMesh& mesh, const Vec3& v) {
  mesh.vertices_m.push_back(v);
  return static_cast<Index>(mesh.vertices_m.size() - 1);
}

void add_quad(TriangleMesh& mesh, Index a, Index b, Index c, Index d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

/// Joins two rings with equal numbers of vertices by quads. The outside is where `lower` runs counter-clockwise below
/// `upper`.
void add_band(TriangleMesh& mesh, const std::vector<Index>& lower, const std::vector<Index>& upper) {
  for (std::size_t i = 0; i < lower.size(); ++i) {
    const std::size_t next = (i + 1) % lower.size();
    add_quad(mesh, lower[i], lower[next], upper[next], upper[i]);
  }
}

void add_cap(TriangleMesh& mesh, const std::vector<Index>& ring, Index tip) {
  for (std::size_t i = 0; i < ring.size(); ++i) mesh.triangles.push_back({ring[i], ring[(i + 1) % ring.size()], tip});
}

/// A surface of revolution about z from a profile (distance from the axis, height) that starts and ends on the axis and
/// has the inside on its left.
TriangleMesh lathe(const std::vector<Point2>& profile, int segments) {
  TriangleMesh mesh;
  const Index first = add_vertex(mesh, {0, 0, profile.front().y()});
  std::vector<Index> below;
  for (std::size_t p = 1; p + 1 < profile.size(); ++p) {
    std::vector<Index> ring;
    for (int s = 0; s < segments; ++s) {
      const double angle = 2 * pi * s / segments;
      ring.push_back(
          add_vertex(mesh, {profile[p].x() * math::cos(angle), profile[p].x() * math::sin(angle), profile[p].y()}));
    }
    if (below.empty()) {
      for (std::size_t i = 0; i < ring.size(); ++i)
        mesh.triangles.push_back({ring[(i + 1) % ring.size()], ring[i], first});
    } else {
      add_band(mesh, below, ring);
    }
    below = ring;
  }
  add_cap(mesh, below, add_vertex(mesh, {0, 0, profile.back().y()}));
  return mesh;
}

/// Adds one arm of the jack, along +z before `turn`: a cylinder that begins at its neighbours' surfaces and ends in a
/// half ball. It begins at the height max(|x|, |y|), because two equal crossed cylinders meet in that plane.
void add_arm(TriangleMesh& mesh, const Mat3& turn, double radius_m, double length_m, int fineness) {
  const int around = 16 * fineness;
  const int cap_rings = 4 * fineness;
  const double straight_m = length_m - radius_m;
  std::vector<Index> below;
  std::vector<double> shares{0.0, 0.5, 1.0};
  for (const double share : shares) {
    std::vector<Index> ring;
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * pi * i / around;
      const double x = radius_m * math::cos(angle);
      const double y = radius_m * math::sin(angle);
      const double start_m = std::max(std::abs(x), std::abs(y));
      ring.push_back(add_vertex(mesh, turn * Vec3(x, y, start_m + share * (straight_m - start_m))));
    }
    if (!below.empty()) add_band(mesh, below, ring);
    below = ring;
  }
  for (int r = 1; r < cap_rings; ++r) {
    const double rise = 0.5 * pi * r / cap_rings;
    std::vector<Index> ring;
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * pi * i / around;
      const double out_m = radius_m * math::cos(rise);
      const Vec3 v(out_m * math::cos(angle), out_m * math::sin(angle), straight_m + radius_m * math::sin(rise));
      ring.push_back(add_vertex(mesh, turn * v));
    }
    add_band(mesh, below, ring);
    below = ring;
  }
  add_cap(mesh, below, add_vertex(mesh, turn * Vec3(0, 0, length_m)));
}

TriangleMesh make_jack(int fineness) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      Mat3 turn = Mat3::Zero();
      turn.col(2) = sign * Vec3::Unit(axis);
      turn.col(0) = Vec3::Unit((axis + 1) % 3);
      turn.col(1) = turn.col(2).cross(turn.col(0));
      add_arm(mesh, turn, 0.12, 0.5, fineness);
    }
  }
  return mesh;
}

TriangleMesh make_torus(int fineness) {
  const int around = 32 * fineness;
  const int tubes = 16 * fineness;
  TriangleMesh mesh;
  for (int a = 0; a < around; ++a) {
    const double ring = 2 * pi * a / around;
    for (int t = 0; t < tubes; ++t) {
      const double tube = 2 * pi * t / tubes;
      const double out_m = 0.35 + 0.15 * math::cos(tube);
      add_vertex(mesh, {out_m * math::cos(ring), out_m * math::sin(ring), 0.15 * math::sin(tube)});
    }
  }
  const auto at = [&](int a, int t) { return static_cast<Index>(a % around * tubes + t % tubes); };
  for (int a = 0; a < around; ++a) {
    for (int t = 0; t < tubes; ++t) add_quad(mesh, at(a, t), at(a + 1, t), at(a + 1, t + 1), at(a, t + 1));
  }
  return mesh;
}

/// A prism over a polygon (counter-clockwise, given with its triangles) between z = -depth/2 and depth/2.
TriangleMesh extrude(const std::vector<Point2>& outline, const std::vector<std::array<Index, 3>>& faces,
                     double depth_m) {
  TriangleMesh mesh;
  std::vector<Index> bottom;
  std::vector<Index> top;
  for (const Point2& p : outline) bottom.push_back(add_vertex(mesh, {p.x(), p.y(), -0.5 * depth_m}));
  for (const Point2& p : outline) top.push_back(add_vertex(mesh, {p.x(), p.y(), 0.5 * depth_m}));
  for (const auto& f : faces) {
    mesh.triangles.push_back({bottom[f[0]], bottom[f[2]], bottom[f[1]]});
    mesh.triangles.push_back({top[f[0]], top[f[1]], top[f[2]]});
  }
  add_band(mesh, bottom, top);
  return mesh;
}

TriangleMesh make_slab(double x_m, double y_m, double z_m) {
  const double x = 0.5 * x_m;
  const double y = 0.5 * y_m;
  return extrude({{-x, -y}, {x, -y}, {x, y}, {-x, y}}, {{0, 1, 2}, {0, 2, 3}}, z_m);
}

TriangleMesh make_l() {
  // Corner 3 is the inner one; all faces meet there.
  return extrude({{-0.4, -0.4}, {0.4, -0.4}, {0.4, -0.15}, {-0.15, -0.15}, {-0.15, 0.4}, {-0.4, 0.4}},
                 {{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}}, 0.25);
}

TriangleMesh make_bowl(int fineness) {
  const int rise = 10 * fineness;
  std::vector<Point2> profile;
  for (int i = 0; i <= rise; ++i) {
    const double angle = 0.5 * pi * i / rise;
    profile.emplace_back(0.5 * math::sin(angle), -0.5 * math::cos(angle));
  }
  for (int i = rise; i >= 0; --i) {
    const double angle = 0.5 * pi * i / rise;
    profile.emplace_back(0.42 * math::sin(angle), -0.42 * math::cos(angle));
  }
  return lathe(profile, 32 * fineness);
}

TriangleMesh make_disc(int fineness) {
  return lathe({{0, -0.06}, {0.5, -0.06}, {0.5, 0.06}, {0, 0.06}}, 32 * fineness);
}

}  // namespace

std::span<const std::string_view> procedural_shapes() {
  static constexpr std::array<std::string_view, 7> kNames{"jack", "torus", "slab", "l", "bowl", "cube", "disc"};
  return kNames;
}

Result<TriangleMesh> make_procedural_shape(std::string_view kind, int fineness) {
  if (fineness < 1 || fineness > kMaxFineness) {
    return bad_input(fmt::format("fineness = {}, must be from 1 to {}", fineness, kMaxFineness));
  }
  TriangleMesh mesh;
  if (kind == "jack") mesh = make_jack(fineness);
  if (kind == "torus") mesh = make_torus(fineness);
  if (kind == "slab") mesh = make_slab(1.0, 0.6, 0.1);
  if (kind == "l") mesh = make_l();
  if (kind == "bowl") mesh = make_bowl(fineness);
  if (kind == "cube") mesh = make_slab(0.7, 0.7, 0.7);
  if (kind == "disc") mesh = make_disc(fineness);
  if (mesh.triangles.empty())
    return bad_input(
        fmt::format("shape '{}' is not known, must be one of {}", kind, fmt::join(procedural_shapes(), " ")));
  for (Vec3& v : mesh.vertices_m) {
    // Adding 0 turns -0 into 0; the file would contain "-0" otherwise.
    for (double& x : v) x = std::round(x * 1e9) / 1e9 + 0.0;
  }
  clean_mesh(mesh, 1e-9);
  return mesh;
}

std::string obj_text(const TriangleMesh& mesh, std::string_view comment) {
  std::string text = fmt::format("# {}\n", comment);
  for (const Vec3& v : mesh.vertices_m) text += fmt::format("v {:.9f} {:.9f} {:.9f}\n", v.x(), v.y(), v.z());
  for (const auto& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

}  // namespace poise::geometry
