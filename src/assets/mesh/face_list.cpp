// SPDX-License-Identifier: MIT
#include "assets/mesh/face_list.h"

#include <fmt/format.h>

namespace poise::geometry {

std::string FaceList::too_few(std::size_t corners) {
  return fmt::format("a face has {} corners, must have at least 3", corners);
}

std::string FaceList::too_many(std::size_t corners) {
  return fmt::format(
      "a face of {} corners: the polygons of the file together need more than {} comparisons to cut, "
      "must have fewer corners or be triangles",
      corners, kMostPolygonTests);
}

std::string FaceList::missing(std::uint32_t corner) const {
  return fmt::format("a face names vertex {} of {}, counted from {}, must exist", std::uint64_t{corner} + first_,
                     mesh_.vertices_m.size(), first_);
}

}  // namespace poise::geometry
