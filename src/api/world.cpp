// SPDX-License-Identifier: MIT
#include "poise/world.h"

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/time_of_impact/least_extent.h"
#include "frame/budget/frame_time.h"
#include "frame/report/conserved_report.h"
#include "frame/run_frame.h"
#include "frame/sliced_step.h"
#include "world/validation.h"

namespace poise {
namespace {

using simulation::check_range;
using simulation::check_vector;
using simulation::stale_body;

simulation::ShapeFacts facts_of(ShapePtr shape) {
  simulation::ShapeFacts facts;
  const SphereTree& tree = shape->tree;
  for (std::size_t level = 0; shape->kind == ShapeKind::Tree && level < facts.error_m.size(); ++level) {
    double area = 0;
    double sum = 0;
    double deviations_m = 0;
    int fitted = 0;
    for (const NodeIndex node : tree.nodes_at(static_cast<Level>(std::min<std::size_t>(level, tree.depth())))) {
      const double r = static_cast<double>(tree.radius_m[node]);
      area += r * r;
      sum += r * r * static_cast<double>(tree.protrusion_mean_m[node]);
      const NodeFit& fit = tree.fit[node];
      if (fit.radius_m < -tree.radius_m[0]) continue;  // no surface
      deviations_m += std::sqrt(static_cast<double>(fit.variance_m2));
      ++fitted;
    }
    facts.deviation_m[level] = fitted > 0 ? deviations_m / fitted : 0.0;
    facts.error_m[level] = static_cast<float>(area > 0 ? sum / area : 0.0);
  }
  facts.least_extent_m = collision::least_extent_m(*shape);
  facts.shape = std::move(shape);
  return facts;
}

MotionType motion_of(const dynamics::BodyStore& bodies, std::size_t slot) {
  if (bodies.kinematic[slot] != 0) return MotionType::Kinematic;
  return bodies.dynamic[slot] == 0 && bodies.asleep[slot] == 0 ? MotionType::Static : MotionType::Dynamic;
}

// A quaternion that is of unit length but for rounding stays as it is, so that a state that is read and set again is
// the same to the bit.
Quat unit(const Quat& turn) {
  constexpr double kRounding = 1e-14;
  return std::abs(turn.squaredNorm() - 1.0) <= kRounding ? turn : Quat(turn.normalized());
}

parallel::ExecutorSettings executor_settings(const WorldSettings& settings) {
  parallel::ExecutorSettings executor;
  executor.kind = settings.executor;
  executor.threads = settings.threads;
  executor.spin = settings.spin;
  executor.processors = settings.processors;
  executor.realtime_priority = settings.realtime_priority;
  executor.host = settings.host_executor;
  return executor;
}

/// The mass of a body that add_body takes; what it says of one that it refuses.
Result<simulation::BodyMass> mass_if_sound(const simulation::WorldState& state, const BodyDefinition& definition) {
  if (definition.shape.index >= state.shapes.size() || !state.shapes[definition.shape.index].shape)
    return bad_input("shape: this World has no such shape");
  if (definition.material.index >= state.materials.size() || state.material_removed[definition.material.index] != 0)
    return bad_input("material: this World has no such material");
  const Shape& shape = *state.shapes[definition.shape.index].shape;
  if (auto bad = simulation::check_body(definition, shape)) return *bad;
  return simulation::mass_of(definition, shape, state.materials[definition.material.index].density_kgpm3);
}

}  // namespace

World::World(std::unique_ptr<simulation::WorldState> state) : state_(std::move(state)) {}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

Result<World> World::create(const WorldSettings& settings) {
  if (auto bad = simulation::check_settings(settings)) return *bad;
  auto executor = parallel::make_executor(executor_settings(settings));
  if (!executor) return executor.error();
  auto state = std::make_unique<simulation::WorldState>();
  state->settings = settings;
  state->executor = std::move(executor).value();
  state->sleeping.on = settings.sleeping;
  simulation::forget_times(state->forecasts, settings.alpha, {});
  const auto workers = static_cast<std::size_t>(state->executor->concurrency());
  for (std::size_t w = 0; w < workers; ++w) state->pools.emplace_back(settings.max_front_entries);
  return World(std::move(state));
}

ShapeId World::add_shape(ShapePtr shape) {
  if (!shape) return {};
  simulation::end_sliced_step(*state_);
  state_->settle();
  state_->shapes.push_back(facts_of(std::move(shape)));
  simulation::find_inner_solids(*state_);
  return {static_cast<std::uint32_t>(state_->shapes.size() - 1)};
}

Result<MaterialId> World::add_material(const Material& material) {
  if (auto bad = check_range("restitution", material.restitution, 0, 1)) return *bad;
  if (auto bad = check_range("friction", material.friction, 0, 1e6)) return *bad;
  if (auto bad = check_range("density_kgpm3", material.density_kgpm3, simulation::kMinDensityKgpm3,
                             simulation::kMaxDensityKgpm3)) {
    return *bad;
  }
  simulation::end_sliced_step(*state_);
  state_->materials.push_back(material);
  state_->material_removed.push_back(0);
  return MaterialId{static_cast<std::uint32_t>(state_->materials.size() - 1)};
}

Status World::check_body(const BodyDefinition& definition) const {
  const Result<simulation::BodyMass> mass = mass_if_sound(*state_, definition);
  if (!mass) return mass.error();
  return Done{};
}

Result<BodyId> World::add_body(const BodyDefinition& definition) {
  const Result<simulation::BodyMass> mass = mass_if_sound(*state_, definition);
  if (!mass) return mass.error();

  const ShapePtr& shape = state_->shapes[definition.shape.index].shape;
  simulation::end_sliced_step(*state_);
  state_->settle();
  dynamics::BodyStore& bodies = state_->bodies;
  const BodyId id = bodies.add();
  const std::size_t i = id.slot;
  const Quat turn = unit(definition.orientation);
  bodies.shape[i] = shape;
  bodies.material[i] = definition.material.index;
  bodies.group[i] = definition.group;
  bodies.collides_with[i] = definition.collides_with;
  bodies.importance[i] = definition.importance;
  bodies.user_data[i] = definition.user_data;
  ++state_->changes;
  bodies.set_orientation(i, turn);
  bodies.set_position(i, definition.position_m + turn * shape->origin_offset_m);
  state_->shape_of.resize(bodies.slot_count());
  state_->shape_of[i] = definition.shape.index;
  simulation::request_wake(state_->sleep_access(), id.slot);
  if (definition.motion == MotionType::Static) return id;
  bodies.set_velocity(i, definition.velocity_mps);
  bodies.set_spin(i, definition.angular_velocity_radps);
  if (definition.motion == MotionType::Kinematic) {
    bodies.make_kinematic(id.slot);
    return id;
  }
  bodies.make_dynamic(id.slot);
  bodies.mass_kg[i] = mass.value().mass_kg;
  bodies.inverse_mass[i] = 1.0 / mass.value().mass_kg;
  bodies.principal_kgm2[i] = mass.value().principal_kgm2;
  return id;
}

Status World::remove_body(BodyId body) {
  if (!contains(body)) return stale_body(body);
  simulation::end_sliced_step(*state_);
  state_->settle();
  simulation::request_wake(state_->sleep_access(), body.slot);
  state_->bodies.remove(body.slot);
  state_->body_changes.removed.push_back(body);
  ++state_->changes;
  if (state_->contacts_version > 0) ++state_->contacts_version;  // without those of the body
  return Done{};
}

bool World::contains(BodyId body) const { return state_->bodies.contains(body); }
std::size_t World::body_count() const { return state_->bodies.alive_count(); }
Result<MotionType> World::motion_type(BodyId body) const {
  if (!contains(body)) return stale_body(body);
  return motion_of(state_->bodies, body.slot);
}
bool World::step_unfinished() const { return state_->frames_unfinished > 0; }

void World::wait_for_workers() { state_->settle(); }

int World::threads() const { return state_->executor->concurrency(); }

Result<BodyState> World::state(BodyId body) const {
  if (!contains(body)) return stale_body(body);
  const dynamics::BodyStore& bodies = state_->bodies;
  return BodyState{bodies.position(body.slot), bodies.orientation(body.slot), bodies.velocity(body.slot),
                   bodies.spin(body.slot)};
}

Status World::set_state(BodyId body, const BodyState& state) {
  if (!contains(body)) return stale_body(body);
  dynamics::BodyStore& bodies = state_->bodies;
  if (auto bad = simulation::check_state(state, motion_of(bodies, body.slot) == MotionType::Static)) return *bad;
  simulation::end_sliced_step(*state_);
  simulation::request_wake(state_->sleep_access(), body.slot);
  ++state_->changes;
  const Quat turn = unit(state.orientation);
  if (bodies.position(body.slot) != state.position_m || bodies.orientation(body.slot).coeffs() != turn.coeffs()) {
    state_->body_changes.displaced.push_back(body.slot);
  }
  bodies.set_position(body.slot, state.position_m);
  bodies.set_orientation(body.slot, turn);
  bodies.set_velocity(body.slot, state.velocity_mps);
  bodies.set_spin(body.slot, state.angular_velocity_radps);
  return Done{};
}

Result<bool> World::asleep(BodyId body) const {
  if (!contains(body)) return stale_body(body);
  return state_->bodies.asleep[body.slot] != 0 && state_->bodies.paused[body.slot] == 0;
}

Result<double> World::mass_kg(BodyId body) const {
  if (!contains(body)) return stale_body(body);
  return state_->bodies.mass_kg[body.slot];
}

Result<ShapePtr> World::shape(BodyId body) const {
  if (!contains(body)) return stale_body(body);
  return state_->bodies.shape[body.slot];
}

Status World::apply_force(BodyId body, const Vec3& force_n, const Vec3& point_m) {
  if (!contains(body)) return stale_body(body);
  simulation::end_sliced_step(*state_);
  dynamics::BodyStore& bodies = state_->bodies;
  if (auto bad = check_vector("point_m", point_m, simulation::kMaxPositionM)) return *bad;
  const Vec3 force = bodies.force(body.slot) + force_n;
  const Vec3 torque = bodies.torque(body.slot) + (point_m - bodies.position(body.slot)).cross(force_n);
  if (auto bad = check_vector("force_n", force, simulation::kMaxForceN)) return *bad;
  if (auto bad = check_vector("torque_nm", torque, simulation::kMaxForceN)) return *bad;
  if (motion_of(bodies, body.slot) != MotionType::Dynamic) return Done{};
  simulation::request_wake(state_->sleep_access(), body.slot);
  bodies.set_force(body.slot, force);
  bodies.set_torque(body.slot, torque);
  bodies.pushed[body.slot] = 1;
  return Done{};
}

Status World::apply_torque(BodyId body, const Vec3& torque_nm) {
  if (!contains(body)) return stale_body(body);
  simulation::end_sliced_step(*state_);
  dynamics::BodyStore& bodies = state_->bodies;
  const Vec3 torque = bodies.torque(body.slot) + torque_nm;
  if (auto bad = check_vector("torque_nm", torque, simulation::kMaxForceN)) return *bad;
  if (motion_of(bodies, body.slot) != MotionType::Dynamic) return Done{};
  simulation::request_wake(state_->sleep_access(), body.slot);
  bodies.set_torque(body.slot, torque);
  bodies.pushed[body.slot] = 1;
  return Done{};
}

Status World::apply_impulse(BodyId body, const Vec3& impulse_ns, const Vec3& point_m) {
  if (!contains(body)) return stale_body(body);
  simulation::end_sliced_step(*state_);
  dynamics::BodyStore& bodies = state_->bodies;
  if (auto bad = check_vector("point_m", point_m, simulation::kMaxPositionM)) return *bad;
  if (auto bad = check_vector("impulse_ns", impulse_ns, simulation::kMaxForceN)) return *bad;
  if (motion_of(bodies, body.slot) != MotionType::Dynamic) return Done{};
  // One that sleeps shows its mass for a moment; set_state wakes it if it accepts the new velocities.
  const bool asleep = bodies.asleep[body.slot] != 0;
  const bool paused = bodies.paused[body.slot] != 0;
  if (asleep) bodies.wake(body.slot);
  BodyState state = this->state(body).value();
  state.velocity_mps += bodies.inverse_mass[body.slot] * impulse_ns;
  state.angular_velocity_radps +=
      dynamics::inverse_inertia_world(bodies, body.slot) * (point_m - state.position_m).cross(impulse_ns);
  if (asleep) paused ? bodies.pause(body.slot) : bodies.put_to_sleep(body.slot);
  return set_state(body, state);
}

Status World::set_groups(BodyId body, std::uint32_t group, std::uint32_t collides_with) {
  if (!contains(body)) return stale_body(body);
  simulation::end_sliced_step(*state_);
  simulation::request_wake(state_->sleep_access(), body.slot);
  state_->bodies.group[body.slot] = group;
  state_->bodies.changed[body.slot] = 1;
  state_->bodies.collides_with[body.slot] = collides_with;
  return Done{};
}

Status World::set_importance(BodyId body, double importance) {
  if (!contains(body)) return stale_body(body);
  if (auto bad = check_range("importance", importance, 0, simulation::kMaxImportance)) return *bad;
  simulation::end_sliced_step(*state_);
  state_->settle();
  state_->bodies.importance[body.slot] = importance;
  return Done{};
}

void World::report_host_work(Nanoseconds actual) { state_->forecasts.host_work.learn(std::min(actual, kFarthestTime)); }
scheduler::TimePriors World::time_priors() const { return simulation::times_of(state_->forecasts); }
void World::set_time_priors(const scheduler::TimePriors& priors) {
  simulation::forget_times(state_->forecasts, state_->settings.alpha, priors);
}
std::span<const Contact> World::contacts() const {
  // What they are listed from is being made anew.
  if (state_->in_slices() && !state_->contacts.built(state_->contacts_version)) return {};
  return state_->contacts.get(state_->contacts_version, [&](std::vector<Contact>& contacts) {
    contacts = simulation::list_contacts(simulation::publish_input(*state_), state_->cache.points,
                                         state_->body_changes.removed, simulation::ContactListing::Touching);
  });
}
std::span<const ContactEvent> World::contact_events() const { return state_->events.events; }
void World::decisions(FrameDecisions& decisions) const {
  if (state_->decisions) {
    state_->decisions->merge(decisions);
  } else {
    simulation::DecisionLog().merge(decisions);
  }
}
Conserved World::conserved() const { return simulation::conserved(*state_); }

std::uint64_t World::state_hash() const {
  const dynamics::BodyStore& bodies = state_->bodies;
  std::uint64_t hash = XXH64(&state_->frame, sizeof(state_->frame), 0);
  const auto mix = [&hash](const auto& column) {
    hash = XXH64(column.data(), column.size() * sizeof(column[0]), hash);
  };
  for (const auto column : dynamics::BodyStore::kColumnsOfState) mix(bodies.*column);
  mix(bodies.mass_kg);
  mix(bodies.importance);
  mix(bodies.generation);
  mix(bodies.alive);
  // The rest is half of the step before and half of this one.
  if (state_->frames_unfinished > 0) return hash;
  mix(bodies.group);
  mix(bodies.collides_with);
  const auto mix_pairs = [&](const simulation::CachedPairList& pairs) {
    for (const simulation::CachedPair& pair : pairs) {
      // Field by field: padding has no defined bits.
      const std::uint64_t words[8] = {std::uint64_t{pair.low} << 32U | pair.high,
                                      pair.frames_waited,
                                      std::uint64_t{pair.level} << 16U | std::uint64_t{pair.point_count} << 8U |
                                          (pair.solved ? 4U : 0U) | (pair.touching ? 2U : 0U) | (pair.apart ? 1U : 0U),
                                      std::bit_cast<std::uint64_t>(pair.reach_m),
                                      std::bit_cast<std::uint64_t>(pair.moved_m),
                                      std::bit_cast<std::uint64_t>(pair.nearest_m),
                                      std::bit_cast<std::uint64_t>(pair.impact_gap_m),
                                      std::bit_cast<std::uint64_t>(pair.looked_m)};
      hash = XXH64(words, sizeof(words), hash);
      if (pair.point_count == 0) continue;
      const std::size_t first = simulation::PointCache::begin(pair.slot);
      hash = XXH64(state_->cache.points.points.data() + first, pair.point_count * sizeof(solver::ContactPoint), hash);
      const std::span<const solver::ContactForce> forces = state_->cache.points.forces_of(pair.slot, pair.point_count);
      hash = XXH64(forces.data(), forces.size_bytes(), hash);
    }
  };
  static_assert(
      sizeof(solver::ContactPoint) == 8 * sizeof(double) && sizeof(solver::ContactForce) == 4 * sizeof(double),
      "no padding in what is hashed");
  mix_pairs(state_->cache.pairs);
  if (bodies.kinematic_count() > 0) mix(bodies.kinematic);
  const std::vector<std::uint8_t>& held = bodies.frames_held;
  if (std::any_of(held.begin(), held.end(), [](std::uint8_t frames) { return frames > 0; })) mix(held);
  if (bodies.paused_count() > 0) mix(bodies.paused);
  const auto mix_ages = [&](const simulation::CachedPairList& pairs) {
    for (const simulation::CachedPair& pair : pairs) {
      if (pair.frames_touched == 0) continue;
      const std::uint64_t words[2] = {std::uint64_t{pair.low} << 32U | pair.high, pair.frames_touched};
      hash = XXH64(words, sizeof(words), hash);
    }
  };
  // Only steps with a budget leave something here.
  mix_ages(state_->cache.pairs);
  if (!state_->learned.empty()) {
    mix(state_->learned.entries());
    mix(std::as_const(state_->learned).observed());
  }
  if (!state_->settings.sleeping && bodies.paused_count() == 0) return hash;
  const simulation::SleepingState& sleep = state_->sleeping;
  mix(bodies.asleep);
  mix(sleep.still_s);
  mix(sleep.island);
  mix(sleep.wake_requested);
  mix(sleep.changed_statics);
  // One list, whatever sets they are in.
  simulation::CachedPairList of_sleepers;
  for (const simulation::SleepingSet& set : sleep.sets)
    of_sleepers.insert(of_sleepers.end(), set.pairs.begin(), set.pairs.end());
  std::sort(of_sleepers.begin(), of_sleepers.end(),
            [](const auto& x, const auto& y) { return std::pair(x.low, x.high) < std::pair(y.low, y.high); });
  mix_pairs(of_sleepers);
  mix_ages(of_sleepers);
  return hash;
}

}  // namespace poise
