// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace poise::geometry {

/// Readers reserve memory for the vertices and faces that a header announces, which may be more than any memory holds.
/// Given the start of an OFF or PLY file (with its header) and the size of the whole file, returns why the announced
/// counts are impossible (each entry takes at least one byte). Empty if they are possible or there is no such header.
/// Also reports a PLY header without faces.
std::string wrong_off_counts(std::string_view start, std::uint64_t file_bytes);
std::string wrong_ply_counts(std::string_view start, std::uint64_t file_bytes);

}  // namespace poise::geometry
