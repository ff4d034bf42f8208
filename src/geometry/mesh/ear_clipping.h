// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "poise/types.h"

namespace poise::geometry {

/// Comparisons that the polygons of one mesh may take together, about a second: one convex polygon of 24,000 corners. A
/// polygon of n corners takes n^2 / 2 if it is convex and at most 3 n^2. Chosen.
inline constexpr std::uint64_t kMostPolygonTests = 300'000'000;

/// Cuts a polygon (corner indices into `vertices_m`, all valid) into triangles by ear clipping (Meisters 1975) in the
/// plane of its Newell normal, and appends them with the same orientation. n corners always give n - 2 triangles, even
/// if the polygon crosses itself or has no area, so that the edges of a closed mesh stay paired. Fewer than three
/// corners give none. The comparisons of corners with triangles are taken from `tests_left`; false if they do not
/// suffice, and then triangles may be missing.
bool triangulate_polygon(std::span<const Vec3> vertices_m, std::span<const std::uint32_t> corners,
                         std::uint64_t& tests_left, std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace poise::geometry
