// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "capture/capture_writer.h"

namespace poise::testing {

/// A header with a ball, a tetrahedron and a plane.
capture::CaptureHeader some_header(bool contacts = false);

/// Frames of bodies that come, move, rest and leave at random; the same for a seed.
std::vector<capture::SeenFrame> some_frames(std::uint64_t seed, std::uint64_t count, std::size_t bodies,
                                            bool contacts = false);

/// The frames as a file; returns its bytes.
std::string written(const std::string& file, const capture::CaptureHeader& header,
                    const std::vector<capture::SeenFrame>& frames, bool stopped = false);

void put_file(const std::string& file, const std::string& bytes);

}  // namespace poise::testing
