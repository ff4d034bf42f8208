// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "geometry/mesh/ear_clipping.h"
#include "poise/mesh.h"

namespace poise::geometry {

/// Adds the faces of a file to a mesh whose vertices are all there. Invariant: every corner of `mesh` exists.
class FaceList {
 public:
  /// Messages count vertices from `first`, as the file does; the corners are counted from 0.
  explicit FaceList(TriangleMesh& mesh, std::uint32_t first = 0) : mesh_(mesh), first_(first) {}

  /// Appends the triangles of a face. Returns what is wrong with it, and then its triangles may be missing; empty if
  /// nothing is.
  std::string add(std::span<const std::uint32_t> corners) {
    if (corners.size() < 3) return too_few(corners.size());
    for (const std::uint32_t corner : corners) {
      if (corner >= mesh_.vertices_m.size()) return missing(corner);
    }
    return triangulate_polygon(mesh_.vertices_m, corners, tests_left_, mesh_.triangles) ? std::string()
                                                                                        : too_many(corners.size());
  }

 private:
  static std::string too_few(std::size_t corners);
  static std::string too_many(std::size_t corners);
  [[nodiscard]] std::string missing(std::uint32_t corner) const;

  TriangleMesh& mesh_;
  std::uint32_t first_;
  std::uint64_t tests_left_ = kMostPolygonTests;
};

}  // namespace poise::geometry
