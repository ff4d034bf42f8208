// SPDX-License-Identifier: MIT
#include "studies/other_engines.h"

namespace poise::app {

Result<std::vector<bench::Engine>> other_engines(const Scene& scene, std::uint64_t bodies) {
  const Result<bench::PileScene> pile = bench::pile_scene(scene, bodies);
  if (!pile) return pile.error();
  return std::vector<bench::Engine>{bench::make_bullet(pile.value()), bench::make_ode(pile.value(), false)};
}

}  // namespace poise::app
