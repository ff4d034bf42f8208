// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "scene/run/numbered_states.h"
#include "scene/run/run_report.h"

namespace poise::io {

/// Header of the table of states, with its newline: one row a frame and body, world frame, 17 digits.
std::string states_header();
/// Header line of the table of bodies that stands beside that of states.
std::string bodies_header();
/// Appends the row of a body: number, name, motion, shape, the file of the shape as the scene names it, material, mass.
void append_body(const Scene& scene, const RunBody& body, double mass_kg, std::string& out);
/// Appends the rows of one frame.
void append_states(std::uint64_t frame, double time_s, std::span<const NumberedState> states, std::string& out);

/// Header of the table of frames, with its newline: every field of FrameReport, times in ms.
std::string frames_header();
/// Appends one row. `time_s` is the time at the end of the frame.
void append_frame(const simulation::RunFrame& frame, double time_s, std::string& out);

}  // namespace poise::io
