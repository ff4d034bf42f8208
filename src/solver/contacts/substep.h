// SPDX-License-Identifier: MIT
#pragma once

#include "solver/contact_solver.h"
#include "solver/contacts/contact_blocks.h"
#include "solver/contacts/contact_lanes.h"
#include "solver/contacts/split_system.h"

/// How a substep of the contact solver begins and ends for a body, and what its lanes are to know of it.
namespace poise::solver {

/// Share of a certain overlap that a substep takes back, and the greatest speed of that. Larger values make a pair pop
/// that has just been refined.
inline constexpr double kPushShare = 0.1;
inline constexpr double kMaxPushMps = 0.3;

/// The figures of a motion one after another: v, w, x, q.
inline constexpr std::size_t kFiguresOfMotion = 12;
template <class T>
T* figures(MotionChange<T>& motion) {
  return motion.v;
}
/// Likewise: v, w.
template <class T>
T* figures(SpeedChange<T>& speed) {
  return speed.v;
}

/// Begins a substep: forces, and from the second one on what contacts gave in the one before.
template <class T>
void begin_substep(const SplitSystem& system, std::size_t i, double h_s, bool first, Lanes<T>& lanes) {
  T* const now = figures(lanes.motions[i]);
  T* const begun = figures(lanes.begun[i]);
  const Acceleration& pull = system.acceleration_of(i);
  const auto begin = [&](int k, double rate) {
    const T before = now[k];
    // The changes of the last substep came from forces and contacts: both are applied again.
    now[k] = first ? before + static_cast<T>(h_s * rate) : before + (before - begun[k]);
    begun[k] = before;
  };
  for (int k = 0; k < 3; ++k) begin(k, pull.linear_mps2[k]);
  for (int k = 0; k < 3; ++k) begin(k + 3, pull.angular_radps2[k]);
}

template <class T>
void end_substep(std::size_t i, double h_s, Lanes<T>& lanes) {
  T* const now = figures(lanes.motions[i]);
  for (std::size_t k = 0; k < 6; ++k) now[k + 6] += static_cast<T>(h_s) * now[k];
}

template <class T>
SubstepTerms<T> terms_of(const SolveSettings& settings, bool watch) {
  const double h_s = settings.dt_s / settings.substeps;
  SubstepTerms<T> terms;
  terms.h_s = static_cast<T>(h_s);
  terms.still_mps = static_cast<T>(still_mps(settings));
  terms.push_share = static_cast<T>(kPushShare);
  terms.most_push_m = static_cast<T>(kMaxPushMps * h_s);
  terms.watch = watch;
  return terms;
}

/// The last substep adds those of the one before it too, which are still at hand.
inline SubstepTotals totals_in(int substep, int substeps) {
  const int left = substeps - 1 - substep;
  return {substep > (left == 0 ? 1 : 0), left == 0 && substep > 0, left != 1};
}

}  // namespace poise::solver
