// SPDX-License-Identifier: MIT
#include "solver/contacts/split_system.h"

#include <array>

#include "parallel/ranges.h"
#include "solver/contacts/substep.h"

namespace poise::solver {
namespace {

template <class Visit>
void for_shared(const SplitSystem& system, parallel::Executor& executor, Visit&& visit) {
  // A few are joined before another thread is awake.
  constexpr std::size_t kGrain = 16;
  const std::span<const SharedBody> shared = system.coloring.shared();
  if (shared.empty()) return;
  parallel::parallel_for(executor, shared.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) visit(shared[i]);
  });
}

}  // namespace

SplitSystem BodyCopies::split(const ContactSystem& system) {
  bodies_.clear();
  inverse_inertia_.clear();
  originals_.clear();
  for (const SharedBody& shared : system.coloring.shared()) {
    SolverBody copy = system.bodies[shared.body];
    copy.inverse_mass *= shared.copies;
    bodies_.insert(bodies_.end(), shared.copies, copy);
    inverse_inertia_.insert(inverse_inertia_.end(), shared.copies, shared.copies * system.inverse_inertia[shared.body]);
    originals_.insert(originals_.end(), shared.copies, shared.body);
  }
  return {system, bodies_, inverse_inertia_, originals_};
}

template <class T>
void join_motions(const SplitSystem& system, std::span<MotionChange<T>> motions, parallel::Executor& executor) {
  for_shared(system, executor, [&](const SharedBody& shared) {
    const std::span<MotionChange<T>> copies = motions.subspan(shared.first, shared.copies);
    // From the first one on, so that copies that are alike stay what they are to the bit.
    MotionChange<T> joined = copies.front();
    std::array<double, kFiguresOfMotion> beyond{};
    for (MotionChange<T>& copy : copies) {
      for (std::size_t k = 0; k < beyond.size(); ++k)
        beyond[k] += static_cast<double>(figures(copy)[k]) - static_cast<double>(figures(joined)[k]);
    }
    for (std::size_t k = 0; k < beyond.size(); ++k) {
      T& figure = figures(joined)[k];
      figure = static_cast<T>(static_cast<double>(figure) + beyond[k] / shared.copies);
    }
    motions[shared.body] = joined;
    for (MotionChange<T>& copy : copies) copy = joined;
  });
}

void join_velocities(const SplitSystem& system, parallel::Executor& executor) {
  for_shared(system, executor, [&](const SharedBody& shared) {
    const std::span<SolverBody> copies = system.copies.subspan(shared.first - system.bodies.size(), shared.copies);
    SolverBody& joined = system.bodies[shared.body];
    const SolverBody first = copies.front();
    Vec3 faster_mps = Vec3::Zero();
    Vec3 faster_radps = Vec3::Zero();
    for (const SolverBody& copy : copies) {
      faster_mps += copy.velocity_mps - first.velocity_mps;
      faster_radps += copy.spin_radps - first.spin_radps;
      joined.solved = joined.solved || copy.solved;
    }
    joined.velocity_mps = first.velocity_mps + faster_mps / shared.copies;
    joined.spin_radps = first.spin_radps + faster_radps / shared.copies;
    for (SolverBody& copy : copies) {
      copy.velocity_mps = joined.velocity_mps;
      copy.spin_radps = joined.spin_radps;
    }
  });
}

template void join_motions(const SplitSystem&, std::span<MotionChange<float>>, parallel::Executor&);
template void join_motions(const SplitSystem&, std::span<MotionChange<double>>, parallel::Executor&);

}  // namespace poise::solver
