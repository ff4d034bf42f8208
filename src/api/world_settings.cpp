// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>

#include "frame/budget/frame_time.h"
#include "frame/sliced_step.h"
#include "frame/world_state.h"
#include "poise/world.h"
#include "world/validation.h"

// What of a World can be changed between steps beside its bodies' motion: settings, the pair filter, shapes, materials,
// and what callers keep with bodies.
namespace poise {
namespace {

using simulation::stale_body;

constexpr const char* kFixed = "is fixed when a World is made";

/// The refusal of a change of what is fixed, or nothing.
std::optional<Error> check_fixed(const WorldSettings& now, const WorldSettings& asked) {
  const auto fixed = [](const char* field, auto is, auto was) {
    return bad_input(fmt::format("{} = {}, must stay {}: it {}", field, is, was, kFixed));
  };
  if (asked.executor != now.executor)
    return fixed("executor", static_cast<int>(asked.executor), static_cast<int>(now.executor));
  if (asked.host_executor != now.host_executor) return bad_input(fmt::format("host_executor: it {}", kFixed));
  if (asked.threads != now.threads) return fixed("threads", asked.threads, now.threads);
  if (asked.spin != now.spin) return fixed("spin", asked.spin.count(), now.spin.count());
  if (asked.processors != now.processors) return bad_input(fmt::format("processors: they must stay; this {}", kFixed));
  if (asked.realtime_priority != now.realtime_priority)
    return fixed("realtime_priority", asked.realtime_priority, now.realtime_priority);
  if (asked.max_front_entries != now.max_front_entries)
    return fixed("max_front_entries", asked.max_front_entries, now.max_front_entries);
  return std::nullopt;
}

/// How many living bodies have this number in a column with one entry a slot.
std::size_t users_of(const dynamics::BodyStore& bodies, const std::vector<std::uint32_t>& column,
                     std::uint32_t number) {
  std::size_t count = 0;
  for (std::size_t slot = 0; slot < bodies.slot_count(); ++slot) {
    if (bodies.alive[slot] != 0 && column[slot] == number) ++count;
  }
  return count;
}

std::string in_use(const char* what, std::uint32_t index, std::size_t count) {
  return fmt::format("{} {} is used by {} {}, must be used by none", what, index, count,
                     count == 1 ? "body" : "bodies");
}

}  // namespace

const WorldSettings& World::settings() const { return state_->settings; }

Status World::set_settings(const WorldSettings& settings) {
  if (auto bad = simulation::check_settings(settings)) return *bad;
  if (auto bad = check_fixed(state_->settings, settings)) return *bad;
  simulation::WorldState& state = *state_;
  const WorldSettings before = state.settings;
  simulation::end_sliced_step(state);
  state.settle();
  // Listed while what they were made from still stands.
  static_cast<void>(contacts());
  if (settings.gravity_mps2 != before.gravity_mps2 || !settings.sleeping)
    simulation::wake_all(state.sleep_access(), *state.executor);
  state.settings = settings;
  simulation::find_inner_solids(state);
  if (before.sleeping && !settings.sleeping) state.sleeping = {};
  state.sleeping.on = settings.sleeping;
  if (settings.contact != before.contact) {
    for (std::uint32_t slot = 0; slot < state.bodies.slot_count(); ++slot) state.body_changes.displaced.push_back(slot);
    state.learned.clear();
  }
  if (settings.max_partners != before.max_partners) state.broad_phase.cache = {};
  if (settings.alpha != before.alpha)
    simulation::forget_times(state.forecasts, settings.alpha, simulation::times_of(state.forecasts));
  return Done{};
}

Status World::set_policy(const scheduler::Policy& policy) {
  WorldSettings settings = state_->settings;
  settings.policy = policy;
  return set_settings(settings);
}

void World::set_pair_filter(const PairFilter& filter) {
  simulation::end_sliced_step(*state_);
  state_->settle();
  simulation::wake_all(state_->sleep_access(), *state_->executor);
  state_->pair_filter = filter;
}

Status World::remove_shape(ShapeId shape) {
  if (shape.index >= state_->shapes.size() || !state_->shapes[shape.index].shape)
    return Error{ErrorKind::StaleHandle, fmt::format("shape {} does not exist", shape.index)};
  if (const std::size_t users = users_of(state_->bodies, state_->shape_of, shape.index); users > 0)
    return bad_input(in_use("shape", shape.index, users));
  simulation::end_sliced_step(*state_);
  state_->settle();
  state_->shapes[shape.index] = {};
  if (state_->reference && shape.index < state_->reference->surfaces.size())
    state_->reference->surfaces[shape.index].reset();
  return Done{};
}

Status World::remove_material(MaterialId material) {
  if (material.index >= state_->materials.size() || state_->material_removed[material.index] != 0)
    return Error{ErrorKind::StaleHandle, fmt::format("material {} does not exist", material.index)};
  if (const std::size_t users = users_of(state_->bodies, state_->bodies.material, material.index); users > 0)
    return bad_input(in_use("material", material.index, users));
  simulation::end_sliced_step(*state_);
  state_->material_removed[material.index] = 1;
  return Done{};
}

std::vector<BodyId> World::bodies() const {
  std::vector<BodyId> ids;
  ids.reserve(state_->bodies.alive_count());
  for (std::uint32_t slot = 0; slot < state_->bodies.slot_count(); ++slot) {
    if (state_->bodies.alive[slot] != 0) ids.push_back(state_->bodies.id_of(slot));
  }
  return ids;
}

Result<std::uint64_t> World::user_data(BodyId body) const {
  if (!contains(body)) return stale_body(body);
  return state_->bodies.user_data[body.slot];
}

Status World::set_user_data(BodyId body, std::uint64_t user_data) {
  if (!contains(body)) return stale_body(body);
  simulation::end_sliced_step(*state_);
  state_->settle();
  // A filter may go by it, and what sleeps is not asked about.
  if (state_->pair_filter.function != nullptr && state_->bodies.user_data[body.slot] != user_data)
    simulation::request_wake(state_->sleep_access(), body.slot);
  state_->bodies.user_data[body.slot] = user_data;
  return Done{};
}

Status World::set_velocity(BodyId body, const Vec3& velocity_mps, const Vec3& angular_velocity_radps) {
  if (!contains(body)) return stale_body(body);
  simulation::end_sliced_step(*state_);
  BodyState state = this->state(body).value();
  state.velocity_mps = velocity_mps;
  state.angular_velocity_radps = angular_velocity_radps;
  return set_state(body, state);
}

}  // namespace poise
