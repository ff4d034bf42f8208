// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/picture/drawn_frame.h"
#include "app/picture/picture.h"
#include "poise/result.h"
#include "poise/types.h"
#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study strips`.
struct StudyStripsOptions {
  StudyTimesOptions common;
  std::string contact = "fitted";
};
void add_study_strips_options(CLI::App& command, StudyStripsOptions& options);

/// How the collision of two bodies goes where its refinement always ends at one level.
struct Strip {
  Level level = 0;          ///< kPolygonBin for polygons
  std::uint64_t balls = 0;  ///< of both bodies at this level; 0 for polygons
  bool met = false;         ///< false: no impulse in the whole run; then the members below but the motions are 0
  double time_s = 0;        ///< of the collision: the start of the step in which the first impulse was given
  double gap_m = 0;         ///< between the true surfaces at that time
  double gap_radii = 0;     ///< the gap as a share of the mean bounding radius of the two
  std::array<Vec3, 2> velocity_mps{Vec3::Zero(), Vec3::Zero()};  ///< at the end
  std::array<Vec3, 2> spin_radps{Vec3::Zero(), Vec3::Zero()};
  std::vector<io::DrawnFrame> moments;  ///< the start, the collision, later by a share of the run, the end
};

/// Two bodies of a scene and what becomes of them at each level.
struct Strips {
  std::string scene;
  std::vector<capture::CapturedShape> shapes;
  std::array<std::uint64_t, 2> bodies{};  ///< places in DrawnFrame::bodies
  std::vector<Strip> strips;              ///< from the root spheres to the polygons
};

/// The same collision, interrupted at each level (the figure 9 of Dingliana and O'Sullivan 2000). Refused: a scene with
/// any other number of dynamic bodies than two, and what the scene refuses.
Result<Strips> collide(const Scene& scene, const SceneRunOptions& start);

/// A row a level.
io::StudyTable strips_table(const Strips& strips, const StudyStripsOptions& options);

/// The strips one below the other: the moments from left to right, at the collision with the balls of the level, at the
/// end with the velocities as arrows. `dark`: on a dark ground.
io::Image strips_picture(const Strips& strips, bool dark = false);
/// The same in lines and areas, for papers: flat colours, no shadows, no ground. Dark where a browser prefers that.
std::string strips_svg(const Strips& strips);

/// Returns the exit code.
int study_strips(const StudyStripsOptions& options);

}  // namespace poise::app
