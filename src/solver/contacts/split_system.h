// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/executor.h"
#include "solver/contact_solver.h"
#include "solver/contacts/contact_lanes.h"

namespace poise::solver {

/// A system with the copies of its shared bodies (shared_bodies.h), which are numbered behind the bodies. Pairs push
/// copies; whatever does so ends with a joining, after which a body and its copies move alike. All references are to
/// what BodyCopies and the system hold.
struct SplitSystem : ContactSystem {
  std::span<SolverBody> copies;
  std::span<const Mat3> inverse_inertia_of_copies;
  std::span<const std::uint32_t> originals;  ///< one a copy

  [[nodiscard]] std::size_t motions() const { return bodies.size() + copies.size(); }
  [[nodiscard]] SolverBody& body(std::size_t i) const {
    return i < bodies.size() ? bodies[i] : copies[i - bodies.size()];
  }
  [[nodiscard]] const Mat3& inverse_inertia_of(std::size_t i) const {
    return i < bodies.size() ? inverse_inertia[i] : inverse_inertia_of_copies[i - bodies.size()];
  }
  [[nodiscard]] const collision::Pose& pose_of(std::size_t i) const {
    return poses[i < bodies.size() ? i : originals[i - bodies.size()]];
  }
  [[nodiscard]] const Acceleration& acceleration_of(std::size_t i) const { return accelerations[body(i).acceleration]; }
  /// The bodies that a pair pushes.
  [[nodiscard]] RowEnds ends_of(std::uint32_t pair) const {
    const std::span<const RowEnds> ends = coloring.ends();
    return ends.empty() ? RowEnds{pairs[pair].a, pairs[pair].b} : ends[pair];
  }
};

/// The copies of a step. A body of n copies has n times its inverse mass and inertia in each of them, so the mean of
/// what they become is what all impulses together make of the body: momentum is kept, and kinetic energy does not grow.
/// Invariant: buffers only grow.
class BodyCopies {
 public:
  /// Copies of what the bodies are.
  SplitSystem split(const ContactSystem& system);

 private:
  std::vector<SolverBody> bodies_;
  std::vector<Mat3> inverse_inertia_;
  std::vector<std::uint32_t> originals_;
};

/// Gives each shared body, and all its copies, the mean of the copies' motions.
template <class T>
void join_motions(const SplitSystem& system, std::span<MotionChange<T>> motions, parallel::Executor& executor);
/// Likewise of velocities, in double precision.
void join_velocities(const SplitSystem& system, parallel::Executor& executor);

extern template void join_motions(const SplitSystem&, std::span<MotionChange<float>>, parallel::Executor&);
extern template void join_motions(const SplitSystem&, std::span<MotionChange<double>>, parallel::Executor&);

}  // namespace poise::solver
