// SPDX-License-Identifier: MIT
#include "frame/report/conserved_report.h"

#include <algorithm>
#include <array>

#include "dynamics/conserved.h"

namespace poise::simulation {

Conserved conserved(const WorldState& world) {
  // Parts of at least so many bodies, which are added up in order.
  constexpr std::size_t kMostParts = 64, kLeastBodies = 2048;
  const std::size_t slots = world.bodies.slot_count();
  const std::size_t bodies = std::max(kLeastBodies, (slots + kMostParts - 1) / kMostParts);
  std::array<Conserved, kMostParts> parts;
  parallel::parallel_for(*world.executor, slots, bodies, [&](std::size_t begin, std::size_t end, int) {
    parts[begin / bodies] = dynamics::conserved_sums(world.bodies, world.settings.gravity_mps2, begin, end);
  });
  Conserved all;
  for (const Conserved& part : parts) {
    all.momentum_ns += part.momentum_ns;
    all.angular_momentum_js += part.angular_momentum_js;
    all.kinetic_j += part.kinetic_j;
    all.potential_j += part.potential_j;
  }
  return all;
}

}  // namespace poise::simulation
