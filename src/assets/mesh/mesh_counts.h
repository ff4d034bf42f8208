// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace poise::geometry {

/// Readers reserve room for as many vertices and faces as a header announces; a header may announce more than any
/// memory holds. Given the start of an OFF or PLY file (with its header) and the size of the whole file, says why the
/// announced counts cannot be true (each entry takes at least one byte); empty when they can, or when there is no such
/// header. A PLY header that has no faces is told here too.
std::string wrong_off_counts(std::string_view start, std::uint64_t file_bytes);
std::string wrong_ply_counts(std::string_view start, std::uint64_t file_bytes);

}  // namespace poise::geometry
