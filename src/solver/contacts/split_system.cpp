// SPDX-License-Identifier: MIT
#include "solver/contacts/split_system.h"

#include <array>

#include "parallel/ranges.h"
#include "solver/contacts/substep.h"

namespace poise::solver {
namespace {

template <class Visit>
void for_shared(const SplitSystem& system, parallel::Executor& executor, Visit&& visit) {
  const std::span<const SharedBody> shared = system.coloring.shared();
  if (shared.empty()) return;
  parallel::parallel_for(executor, shared.size(), 1, [&](std::size_t begin, std::size_t end, int) {
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
    std::array<double, kFiguresOfMotion> sum{};
    for (MotionChange<T>& copy : copies) {
      for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += static_cast<double>(figures(copy)[k]);
    }
    MotionChange<T>& joined = motions[shared.body];
    for (std::size_t k = 0; k < sum.size(); ++k) figures(joined)[k] = static_cast<T>(sum[k] / shared.copies);
    for (MotionChange<T>& copy : copies) copy = joined;
  });
}

void join_velocities(const SplitSystem& system, parallel::Executor& executor) {
  for_shared(system, executor, [&](const SharedBody& shared) {
    const std::span<SolverBody> copies = system.copies.subspan(shared.first - system.bodies.size(), shared.copies);
    SolverBody& joined = system.bodies[shared.body];
    Vec3 velocity_mps = Vec3::Zero();
    Vec3 spin_radps = Vec3::Zero();
    for (const SolverBody& copy : copies) {
      velocity_mps += copy.velocity_mps;
      spin_radps += copy.spin_radps;
      joined.solved = joined.solved || copy.solved;
    }
    joined.velocity_mps = velocity_mps / shared.copies;
    joined.spin_radps = spin_radps / shared.copies;
    for (SolverBody& copy : copies) {
      copy.velocity_mps = joined.velocity_mps;
      copy.spin_radps = joined.spin_radps;
    }
  });
}

template void join_motions(const SplitSystem&, std::span<MotionChange<float>>, parallel::Executor&);
template void join_motions(const SplitSystem&, std::span<MotionChange<double>>, parallel::Executor&);

}  // namespace poise::solver
