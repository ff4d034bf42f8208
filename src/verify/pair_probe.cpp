// SPDX-License-Identifier: MIT
#include "verify/pair_probe.h"

#include <limits>
#include <utility>

#include "frame/stages.h"

namespace poise::simulation {
namespace {

// Entries that the fronts of one pair have room for.
constexpr std::uint32_t kRoomOfPair = 1U << 20U;

}  // namespace

StepInput step_to(ProbeLevel level, double dt_s) {
  StepInput input;
  input.dt_s = dt_s;
  input.max_level = level.level;
  input.polygons = level.polygons;
  return input;
}

// All pairs of bodies in one World, far from each other.
Result<World> PairProbe::world_of(const PairSettings& settings, std::span<const PairState> states, std::uint32_t room) {
  if (!settings.a || !settings.b) return bad_input("a, b: must be shapes");
  WorldSettings world_settings;
  world_settings.contact = settings.contact;
  world_settings.executor = ExecutorKind::Serial;
  world_settings.threads = 1;
  world_settings.max_front_entries = room;
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
  Result<World> world = world_of(settings, {&apart, 1}, kRoomOfPair);
  if (!world) return world.error();
  return PairProbe(std::move(world).value());
}

PairProbe::PairProbe(World world) : world_(std::move(world)) {}

// The stages of a step up to the rows.
bool PairProbe::pose(const PairState& state, ProbeLevel level, double dt_s, Reach reach) {
  if (!world_.set_state({0, 0}, state.a) || !world_.set_state({1, 0}, state.b)) return false;
  WorldState& world = *world_.state_;
  const StepInput input = step_to(level, dt_s);
  FrameReport report;
  predict(world, input);
  find_pairs(world, input, report);
  world.buffers.pools[0].clear();
  for (std::size_t i = 0; i < world.buffers.pairs.size(); ++i) {
    ActivePair& pair = world.buffers.pairs[i];
    refine_pair(world, pair, world.buffers.found[i], 0);
    if (reach == Reach::Found) pair.margin_m = std::numeric_limits<double>::max();
  }
  list_contact_pairs(world, dt_s, 0, report);
  fill_rows(world);
  return !world.buffers.manifolds.empty();
}

PairAnswer PairProbe::solve(const PairState& state, double dt_s) {
  WorldState& world = *world_.state_;
  solver::solve_impacts(impact_system(world), {dt_s, Vec3::Zero(), 1, {}}, *world.executor);
  const solver::SolverBody& a = world.buffers.solver_bodies[0];
  const solver::SolverBody& b = world.buffers.solver_bodies[1];
  PairAnswer answer;
  answer.met = true;
  answer.level = world.buffers.pairs.front().level.level;
  answer.dv_a_mps = a.velocity_mps - state.a.velocity_mps;
  answer.dw_a_radps = a.spin_radps - state.a.angular_velocity_radps;
  answer.dv_b_mps = b.velocity_mps - state.b.velocity_mps;
  answer.dw_b_radps = b.spin_radps - state.b.angular_velocity_radps;
  return answer;
}

PairAnswer PairProbe::answer(const PairState& state, ProbeLevel level, double dt_s) {
  if (!pose(state, level, dt_s, Reach::Found)) return {};
  solver::ContactRow& row = world_.state_->buffers.rows.front();
  const double gap_m = row.gap_m;
  row.gap_m = -std::numeric_limits<double>::max();
  PairAnswer answer = solve(state, dt_s);
  answer.gap_m = gap_m;
  return answer;
}

bool PairProbe::acts(const PairState& state, ProbeLevel level, double dt_s) {
  if (!pose(state, level, dt_s, Reach::Step)) return false;
  const PairAnswer answer = solve(state, dt_s);
  return !answer.dv_a_mps.isZero(0) || !answer.dv_b_mps.isZero(0);
}

}  // namespace poise::simulation
