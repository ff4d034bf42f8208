// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "collision/broad_phase/broad_phase.h"
#include "dynamics/body_store.h"

namespace poise::simulation {

/// Crowds by the volume of bodies: the less of its ball a body fills, the more others may be within reach of it. Solid
/// balls of one size find 6 to 10 by their own searches, where they lie close together; rods and jacks more.
class CrowdedByVolume final : public collision::CrowdedBodies {
 public:
  explicit CrowdedByVolume(const dynamics::BodyStore& bodies) : bodies_(bodies) {}
  [[nodiscard]] std::uint32_t most_partners(std::uint32_t slot) const override;

 private:
  const dynamics::BodyStore& bodies_;
};

}  // namespace poise::simulation
