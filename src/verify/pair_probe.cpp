// SPDX-License-Identifier: MIT
#include "verify/pair_probe.h"

#include <memory>
#include <utility>

#include "frame/run_frame.h"
#include "verify/pair_stages.h"

namespace poise::simulation {
namespace {

// Capacity of the front of one pair.
constexpr std::uint32_t kEntriesOfPair = 1U << 20U;

}  // namespace

StepInput step_to(ProbeLevel level, double dt_s) {
  StepInput input;
  input.dt_s = dt_s;
  input.max_level = level.level;
  input.polygons = level.polygons;
  return input;
}

// Adds all pairs of bodies to one World, far from each other.
Result<World> PairProbe::world_of(const PairSettings& settings, std::span<const PairState> states,
                                  std::uint32_t capacity) {
  if (!settings.a || !settings.b) return bad_input("a, b: must be shapes");
  WorldSettings world_settings;
  world_settings.contact = settings.contact;
  world_settings.executor = ExecutorKind::Serial;
  world_settings.threads = 1;
  world_settings.max_front_entries = capacity;
  Result<World> world = World::create(world_settings);
  if (!world) return world.error();
  const Result<MaterialId> material = world.value().add_material({settings.restitution, 0, settings.density_kgpm3});
  if (!material) return material.error();
  BodyDefinition body;
  body.material = material.value();
  const ShapeId shapes[2] = {world.value().add_shape(settings.a), world.value().add_shape(settings.b)};
  const double spacing_m = 100 * (settings.a->bounding_radius_m + settings.b->bounding_radius_m);
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (const std::size_t side : {0U, 1U}) {
      BodyState state = side == 0 ? states[i].a : states[i].b;
      state.position_m.x() += spacing_m * static_cast<double>(i);
      body.shape = shapes[side];
      const Result<BodyId> id = world.value().add_body(body);
      if (!id) return id.error();
      const Status placed = world.value().set_state(id.value(), state);
      if (!placed) return placed.error();
    }
  }
  return world;
}

Result<PairProbe> PairProbe::make(const PairSettings& settings) {
  const PairState apart;
  Result<World> world = world_of(settings, {&apart, 1}, kEntriesOfPair);
  if (!world) return world.error();
  return PairProbe(std::move(world).value());
}

PairProbe::PairProbe(World world) : world_(std::move(world)), stages_(std::make_unique<PairStages>(*world_.state_)) {}
PairProbe::PairProbe(PairProbe&&) noexcept = default;
PairProbe& PairProbe::operator=(PairProbe&&) noexcept = default;
PairProbe::~PairProbe() = default;

// Runs the stages of a step up to the rows.
bool PairProbe::pose(const PairState& state, ProbeLevel level, double dt_s, Reach reach) {
  if (!world_.set_state({0, 0}, state.a) || !world_.set_state({1, 0}, state.b)) return false;
  stages_->find(level, dt_s);
  stages_->refine_all(true);
  if (reach == Reach::Found) stages_->meet_all();
  stages_->make_rows();
  return !stages_->frame().manifolds.manifolds.empty();
}

PairImpulse PairProbe::solve(const PairState& state) {
  stages_->solve();
  const Frame& frame = stages_->frame();
  const solver::SolverBody& a = frame.velocities.bodies[0];
  const solver::SolverBody& b = frame.velocities.bodies[1];
  PairImpulse answer;
  answer.met = true;
  answer.level = frame.levels.progress.front().level.level;
  answer.dv_a_mps = a.velocity_mps - state.a.velocity_mps;
  answer.dw_a_radps = a.spin_radps - state.a.angular_velocity_radps;
  answer.dv_b_mps = b.velocity_mps - state.b.velocity_mps;
  answer.dw_b_radps = b.spin_radps - state.b.angular_velocity_radps;
  return answer;
}

PairImpulse PairProbe::impulse(const PairState& state, ProbeLevel level, double dt_s) {
  if (!pose(state, level, dt_s, Reach::Found)) return {};
  const double gap_m = stages_->frame().velocities.rows.front().gap_m;
  stages_->close_gaps();
  PairImpulse answer = solve(state);
  answer.gap_m = gap_m;
  return answer;
}

bool PairProbe::acts(const PairState& state, ProbeLevel level, double dt_s) {
  if (!pose(state, level, dt_s, Reach::Step)) return false;
  const PairImpulse answer = solve(state);
  return !answer.dv_a_mps.isZero(0) || !answer.dv_b_mps.isZero(0);
}

}  // namespace poise::simulation
