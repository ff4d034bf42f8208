// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "frame/integrate.h"
#include "world/body_changes.h"

/// Stage *publish*: the contact cache for the next frame, and events.
namespace poise::simulation {

struct PublishInput {
  SceneView scene;
  ContactModel contact = ContactModel::Fitted;
  const PredictedMotion& motion;
  const PairTable& table;
  const CompletedLevels& levels;
  const Manifolds& manifolds;
  const Velocities& velocities;
  const StepMotions& motions;
  bool persist_events = false;  ///< StepInput::persist_events

  [[nodiscard]] SolvedPair solved_pair(const PointCache& points) const {
    return {scene, motion, table, levels, manifolds, points, contact};
  }
};

/// Output of *publish* beside the contact cache and the events.
struct Publication {
  parallel::UnsetVector<std::uint8_t> touch_changed;  ///< one an active pair: its contact began or ended
  parallel::UnsetVector<Vec3> touch_ns;        ///< likewise: the impulse that an event of it tells, if there is one
  parallel::UnsetVector<std::uint32_t> place;  ///< likewise: of what the next step has cached of it

  parallel::UnsetVector<ContactEvent> of_active, of_inactive;  // scratch: events, each list in canonical order
  std::vector<std::size_t> counts;                             // scratch
};

/// Replaces the cached pairs by those of this step, and leaves those before as previous_pairs; releases slots of
/// points, and lists the events.
void publish(const PublishInput& input, ContactCache& cache, ContactEvents& events, Publication& publication,
             parallel::Executor& executor);

/// Of the contact of a manifold its bodies, level, place and normal, and nothing else. Any thread between steps.
Contact contact_outline(const PublishInput& input, const PointCache& points, std::size_t manifold);

/// Which pairs of the last step are listed.
enum class ContactListing : std::uint8_t {
  Touching,  ///< those that touch, as events tell
  Solved,    ///< also those that the solver had because they may touch within the step, and did not
};
/// The contacts of the last step but for bodies that were removed since, in order of slots. Any thread between steps.
std::vector<Contact> list_contacts(const PublishInput& input, const PointCache& points, std::span<const BodyId> removed,
                                   ContactListing listing);

}  // namespace poise::simulation
