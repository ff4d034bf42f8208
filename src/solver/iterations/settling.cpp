// SPDX-License-Identifier: MIT
#include "solver/iterations/settling.h"

#include <cstddef>

namespace poise::solver {
namespace {

Vec3 vector(const double (&from)[3]) { return {from[0], from[1], from[2]}; }

}  // namespace

bool Settling::settled(const SplitSystem& system, std::span<const MotionChange<double>> now,
                       std::span<const SpeedChange<double>> begun, double h_s, std::uint32_t iterations, double share) {
  const bool due = iterations >= kFirst && (iterations & (iterations - 1)) == 0;
  if (!due) return false;
  const bool compared = half_.size() == now.size();
  double late2 = 0;
  double all2 = 0;
  for (std::size_t i = 0; compared && i < now.size(); ++i) {
    const SolverBody& body = system.bodies[i];
    if (body.inverse_mass == 0) continue;
    const double per_inertia = system.inverse_inertia[i].trace() / (3 * body.inverse_mass);
    const double inertia_per_mass_m2 = per_inertia > 0 ? 1 / per_inertia : 0;
    const Acceleration& pull = system.acceleration_of(i);
    const auto square = [&](const Vec3& v, const Vec3& w) {
      return v.squaredNorm() + inertia_per_mass_m2 * w.squaredNorm();
    };
    late2 += square(vector(now[i].v) - vector(half_[i].v), vector(now[i].w) - vector(half_[i].w));
    all2 += square(vector(now[i].v) - vector(begun[i].v) - h_s * pull.linear_mps2,
                   vector(now[i].w) - vector(begun[i].w) - h_s * pull.angular_radps2);
  }
  half_.assign(now.begin(), now.end());
  return compared && late2 <= share * share * all2;
}

}  // namespace poise::solver
