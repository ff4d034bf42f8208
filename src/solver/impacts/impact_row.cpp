// SPDX-License-Identifier: MIT
#include "solver/impacts/impact_row.h"

#include <cmath>

namespace poise::solver {

bool prepare_wrench(double inverse_mass_a, const Mat3& inverse_inertia_a, double inverse_mass_b,
                    const Mat3& inverse_inertia_b, Wrench& wrench, Turns& turns) {
  turns.a.noalias() = inverse_inertia_a * wrench.moment_a_m;
  turns.b.noalias() = inverse_inertia_b * wrench.moment_b_m;
  const double k = wrench.direction.squaredNorm() * (inverse_mass_a + inverse_mass_b) + wrench.moment_a_m.dot(turns.a) +
                   wrench.moment_b_m.dot(turns.b);
  // Opposed normals can cancel; below 1e-7 of what one contact would have the row counts as degenerate.
  const bool sound = std::isfinite(k) && k > 1e-7 * (inverse_mass_a + inverse_mass_b);
  wrench.effective_mass = sound ? 1.0 / k : 0.0;
  return sound;
}

}  // namespace poise::solver
