// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "poise/mesh.h"

namespace poise::geometry {

/// Result of orient_triangles.
struct Orientation {
  std::size_t triangles_turned = 0;  ///< reversed to agree with their neighbours
  std::size_t pieces_turned = 0;     ///< inside out as a whole and reversed, with what they enclose
  bool all_turned = false;           ///< every piece was reversed
};

/// Reverses triangles in place so that the mesh has an outside; the order of the triangles stays.
///
/// First step, neighbours: two triangles that share an edge with no third one must run through it in opposite
/// directions; the smaller part of a patch is reversed. If that leaves more inconsistent edges than the file had, the
/// file's orientation stays (a Moebius strip, patches that meet at edges of three triangles). Second step, pieces: a
/// piece that encloses a negative volume and lies in no other closed piece is reversed together with everything inside
/// it. So a cavity stays a cavity, and a file that is inside out as a whole is corrected. An open piece is closed by
/// cones from its holes' edges to their middle.
///
/// A second call changes nothing. Each triangle must name three different vertices that exist.
Orientation orient_triangles(TriangleMesh& mesh);

}  // namespace poise::geometry
