// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "frame/refine/refine.h"
#include "frame/view_cues.h"
#include "parallel/disjoint_sets.h"
#include "world/sleeping_state.h"

/// The islands of a frame, what they hold, and which of them may wait. What decides on waiting goes by them.
namespace poise::simulation {

/// A body that waits is stepped in every so many steps: in view, if it is a degree in radius or more; out of view. What
/// is seen smaller may wait for as many more, until as long as what is out of view: a lag has half the visible angle
/// from twice as far.
inline constexpr std::size_t kMostTurns = kMostFramesHeld + 1, kMostTurnsUnseen = kMostStepsUnseen + 1;
[[nodiscard]] std::size_t most_turns(const View& view, std::uint32_t angle_urad);
/// In microradians, at least 1; 0 out of view, or without a viewer.
[[nodiscard]] std::uint32_t visible_angle_urad(const ViewQuery& view_query, const Vec3& center_m, double radius_m);

/// An island is what the frame's pairs connect, static bodies aside; its root is its lowest slot. It is near rest if no
/// body is faster (|v| or R |w|) than gravity makes it in 32 steps, one in ten at most faster than in 8, and half of
/// them at most faster than in 2. May not wait: islands with a body that the caller pushes, that meets a moving
/// kinematic one, or that has waited in the last kMostFramesHeld frames.
class Islands {
 public:
  Islands(const RefineInput& input, IslandSums& sums, parallel::Executor& executor);

  /// May an island wait at all in this World and step?
  [[nodiscard]] static bool any_may_wait(const RefineInput& input);
  /// Is it worth a look? Where only islands near rest wait, not unless there are many slow bodies.
  [[nodiscard]] bool worth_a_look() const;
  /// Finds the islands and adds up what they hold. Islands that may come near each other if one of them stands still
  /// are one: in this step, or with `apart_s` if it does for so long.
  void find(const parallel::UnsetVector<PairProgress>& progress, double apart_s = 0);
  /// Adds up how well the pairs are seen of which something is left to find out.
  void weigh_pairs(const parallel::UnsetVector<PairProgress>& progress);
  /// Adds up how well the bodies are seen, and finds the largest visible angle of them.
  void weigh_bodies();

  /// Of the slots, those that are roots of islands that may wait, ascending.
  template <class Use>
  void for_each_that_may_wait(Use&& use) const {
    const std::span<const std::uint32_t> visited = input_.motion.visited;
    parallel::serial_for(executor_, visited.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (const std::uint32_t slot : visited.subspan(begin, end - begin)) {
        if (may_wait(slot)) use(slot);
      }
    });
  }
  [[nodiscard]] bool may_wait(std::uint32_t root) const;
  [[nodiscard]] bool near_rest(std::uint32_t root) const;
  /// Sorts roots by who waits first: islands near rest before others, of both the least seen first.
  void sort_by_turn(std::vector<std::uint32_t>& roots) const;
  [[nodiscard]] IslandSums::Island& operator[](std::uint32_t root) const { return sums_.islands[root]; }
  [[nodiscard]] std::uint32_t root_of(std::uint32_t slot) const { return roots_.root(slot); }
  /// Slot of a body that moves freely in a pair.
  [[nodiscard]] std::uint32_t dynamic_of(const ActivePair& pair) const {
    return bodies_.dynamic[pair.a] != 0 ? pair.a : pair.b;
  }

  /// Calls use(i) for [0, count), in parallel.
  template <class Use>
  void each(std::size_t count, Use&& use) const {
    parallel::parallel_for(executor_, count, kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) use(static_cast<std::uint32_t>(i));
    });
  }

 private:
  static constexpr std::size_t kGrain = 1024;
  template <class Use>
  void sum(std::size_t count, Use&& use);
  void unite_near(double apart_s);
  void unite_in_reach();
  void note_driven();
  [[nodiscard]] double speed_mps(std::size_t slot) const;
  [[nodiscard]] bool waits_before(std::uint32_t x, std::uint32_t y) const;

  const RefineInput& input_;
  const dynamics::BodyStore& bodies_;
  const double gravity_mps_;
  IslandSums& sums_;
  parallel::Executor& executor_;
  parallel::DisjointSets roots_;
};

}  // namespace poise::simulation
