// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "poise/step.h"
#include "poise/types.h"
#include "poise/world.h"
#include "scene/made_by.h"

/// What a capture of a run holds (docs/capture.md), as plain values. For the file see capture_writer.h and
/// capture_reader.h.
namespace poise::capture {

inline constexpr std::string_view kSchema = "poise.capture/1";
/// The most frames of a block, and the size before compression at which it ends.
inline constexpr std::uint32_t kMostBlockFrames = 60;
inline constexpr std::size_t kBlockBytes = std::size_t{256} << 10U;
/// The largest coordinate in steps of position, so that sums of a few stay exact in a double.
inline constexpr std::int64_t kMostSteps = std::int64_t{1} << 49U;

/// How finely the components of orientations may be captured.
inline constexpr std::uint32_t kLeastOrientationSteps = 16;
inline constexpr std::uint32_t kMostOrientationSteps = 1U << 20U;

/// How a body took part in a frame.
enum class BodyActivity : std::uint8_t { Static, Kinematic, Moving, Asleep, Held, Paused };
inline constexpr std::uint8_t kActivities = 6;
/// Levels of bodies: 0 for none, else the level + 1.
inline constexpr std::uint8_t kMostBodyLevel = kPolygonBin + 1;

/// A position in steps, and an orientation by the three components that are not the largest (docs/capture.md).
struct PackedPose {
  std::array<std::int64_t, 3> position{};
  std::array<std::int32_t, 3> orientation{};
  std::uint8_t largest = 0;
  friend bool operator==(const PackedPose&, const PackedPose&) = default;
};

/// A pair that touches, by rows of the table of bodies.
struct PackedContact {
  std::uint32_t a = 0, b = 0;
  Level level = 0;
  std::array<std::int16_t, 3> normal{};  ///< from a to b, times 32767
  std::uint8_t point_count = 0;
  std::array<std::array<std::int64_t, 3>, Contact::kMostPoints>
      points{};  ///< in steps, world frame; the first point_count are valid
  friend bool operator==(const PackedContact&, const PackedContact&) = default;
};

/// What a frame says beside its bodies. Times in 100 ns.
struct FrameFacts {
  std::uint64_t frame = 0;  ///< frames done; 0 is the start
  double time_s = 0;
  std::uint32_t left_out = 0;  ///< frames directly before this one that are not in the capture
  bool measured = false;       ///< a step was done: times and counts are its
  bool warm_up = false;
  bool has_view = false;
  MissCause cause = MissCause::None;
  std::array<double, 3> position_m{};
  std::array<float, 3> forward{}, up{}, gaze{};
  float vertical_fov_rad = 0, aspect = 0;
  std::array<float, 2> gaze_px{};
  /// predict broad_phase coarse refine manifolds solve integrate publish total, then the host's work
  std::array<std::uint32_t, 10> times{};
  std::uint32_t budget = 0, reserve = 0, lateness = 0;
  /// Dynamic bodies, candidate pairs, coarse pairs, contact pairs, pairs left, levels completed, levels discarded,
  /// bodies asleep, held, paused.
  std::array<std::uint32_t, 10> counts{};
  std::array<std::uint32_t, kPolygonBin + 1> levels{};
  std::uint64_t work = 0;
  double kinetic_j = std::numeric_limits<double>::quiet_NaN();
  double potential_j = std::numeric_limits<double>::quiet_NaN();
  /// Linear, of the dynamic bodies, kg m/s; NaN where it was not measured, and of captures of earlier versions. In the
  /// file it stands beside the frames, in the SUMS chunk of their block.
  std::array<float, 3> momentum_ns{std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN(),
                                   std::numeric_limits<float>::quiet_NaN()};
};

/// A frame as the file holds it. All columns of bodies have one entry for each row, ascending.
struct PackedFrame {
  FrameFacts facts;
  std::vector<std::uint32_t> rows;
  std::vector<PackedPose> poses;
  std::vector<std::uint8_t> activity, level, priority;
  std::vector<PackedContact> contacts;
};

/// A row of the table of bodies.
struct CapturedBody {
  std::uint64_t number = 0;  ///< RunBody::number
  std::uint32_t shape = 0, material = 0;
  MotionType motion = MotionType::Dynamic;
  double mass_kg = 0;
  std::string name;
  friend bool operator==(const CapturedBody&, const CapturedBody&) = default;
};

/// A sphere of a shape for drawing.
struct CapturedSphere {
  float x_m = 0, y_m = 0, z_m = 0, radius_m = 0;
};

/// A shape for drawing, in the frame of the body.
struct CapturedShape {
  std::string name;
  bool plane = false;
  double radius_m = 0;             ///< of the ball around the centre of mass; 0 for planes
  std::array<double, 3> normal{};  ///< planes: normal . x = offset_m
  double offset_m = 0;
  std::vector<float> vertices_m;  ///< x y z each
  std::vector<std::uint32_t> corners;
  std::vector<std::vector<CapturedSphere>> levels;
};

struct CapturedMaterial {
  std::string name;
  double friction = 0, restitution = 0, density_kgpm3 = 0;
};

/// The camera of a scene, as far as frames do not say it.
struct CapturedCamera {
  std::array<double, 2> resolution_px{};
  bool moves = false;
};

/// What is known before the first frame. Shapes are in chunks of their own, but for what the header says of them.
struct CaptureHeader {
  std::string scene;
  std::vector<std::string> command;
  io::BuildFacts build;
  io::Machine machine;
  double dt_s = 0;
  std::optional<double> deadline_ms;
  bool paced = false;
  std::optional<std::uint64_t> frames_asked;
  std::array<double, 3> gravity_mps2{};
  int threads = 1;
  std::string policy, contact;
  double position_step_m = 1e-3;
  std::uint32_t orientation_steps = 4096;
  bool contacts = false;
  bool pairs = false;  ///< of a writer: PAIR chunks too. They speak for themselves, so the header in the file does not
  std::optional<CapturedCamera> camera;
  std::vector<CapturedMaterial> materials;
  std::vector<CapturedShape> shapes;
};

/// What the end of a capture says.
struct CaptureEnd {
  std::uint64_t frames = 0, left_out = 0;
  bool stopped = false;  ///< by Ctrl-C or SIGTERM
};

}  // namespace poise::capture
