// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "poise/mesh.h"

namespace poise::geometry {

/// What orient_triangles turned over.
struct Orientation {
  std::size_t triangles_turned = 0;  ///< to agree with their neighbours
  std::size_t pieces_turned = 0;     ///< that were inside out as a whole, with what they enclose
  bool all_turned = false;           ///< every piece was
};

/// Turns triangles over so that the mesh has an outside, in place; the order of the triangles stays.
///
/// First neighbours: triangles that share an edge with no third one are made to run through it in opposite directions,
/// the smaller part of a patch giving way; where that leaves more edges in disagreement than the file had, the file's
/// way stays (a Moebius strip, patches that meet at edges of three). Then pieces: a piece that encloses a negative
/// volume and lies in no other closed piece is turned over together with whatever lies inside it, so that a cavity
/// stays a cavity and a file that is inside out as a whole comes right. An open piece counts as closed by cones from
/// its holes' edges to their middle.
///
/// A second call changes nothing. No triangle may name a vertex twice or one that does not exist.
Orientation orient_triangles(TriangleMesh& mesh);

}  // namespace poise::geometry
