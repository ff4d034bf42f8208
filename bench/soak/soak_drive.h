// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/primitives/random.h"
#include "poise/scene/scene.h"

namespace poise::soak {

/// Frames after which a soak begins again with other random numbers: the tray is filled for eight seconds, and is empty
/// before the next.
inline constexpr std::uint64_t kCycle = 900;

struct SoakSettings {
  double per_second = 1000;  ///< bodies that come while the tray is filled
  Nanoseconds deadline{8'000'000};
  std::optional<std::uint64_t> work;  ///< node-pair expansions of a frame, in place of the deadline
  int threads = 2;
  std::uint64_t seed = 1;
};

struct SoakFrame {
  FrameReport report;
  std::uint64_t allocations = 0;  ///< calls of operator new within the step
  bool same = false;              ///< the replay has the same state
};

/// What was counted from the start on.
struct SoakCounts {
  std::uint64_t frames = 0, added = 0, removed = 0;
  std::uint64_t recycled = 0;        ///< bodies that came into a slot which another one had
  std::uint64_t most_at_once = 0;    ///< bodies that come and go
  std::uint64_t slots = 0;           ///< that bodies which come and go have had
  std::uint64_t stale_asked = 0;     ///< calls with a handle of a body that has left
  std::uint64_t stale_accepted = 0;  ///< of these, that were not refused as StaleHandle
  std::uint64_t out_of_range = 0;
};

/// The bodies of a stream come and go without end while budgets pulse and the gaze jumps, and each frame is repeated at
/// once in a second World from what the first one decided, on one thread. Invariant: what is kept does not grow with
/// the frames.
class SoakDrive {
 public:
  /// Refused: as SceneRun::create, and a scene without a camera or whose only generator is not a stream with a life.
  static Result<SoakDrive> create(const Scene& scene, const SoakSettings& settings);
  /// Bodies leave and come, then a step and its repetition. Refused: what the World refuses.
  Result<SoakFrame> step();
  [[nodiscard]] const SoakCounts& counts() const { return counts_; }

 private:
  struct Present {
    BodyId id;
    std::uint64_t leaves = 0;  ///< frame
  };
  SoakDrive(const Scene& scene, const SoakSettings& settings, const StreamGenerator& stream, SceneRun first,
            SceneRun second);
  Status add_kinds(World& world);
  Status remove_due();
  Status add_due();
  void ask_stale();
  StepInput input();
  [[nodiscard]] Budget budget() const;

  Scene scene_;
  SoakSettings settings_;
  StreamGenerator stream_;
  SceneRun first_, second_;
  std::vector<ShapeId> shapes_;  ///< the same in both worlds, as all ids are
  std::vector<MaterialId> materials_;
  std::vector<Present> present_;  ///< a ring: from first_present_ on, in order of arrival
  std::size_t first_present_ = 0, present_count_ = 0;
  std::array<BodyId, 4096> left_{};  ///< of any time, chosen at random
  std::size_t left_count_ = 0;
  geometry::Random random_;
  double owed_ = 0;  ///< bodies
  Vec3 looked_at_m_ = Vec3::Zero();
  FrameDecisions decisions_;
  SoakCounts counts_;
};

}  // namespace poise::soak
