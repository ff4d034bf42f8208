// SPDX-License-Identifier: MIT
#include "response/rest_blocks.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cstddef>

namespace poise::response {
namespace {

template <class T>
void set(const Vec3& from, std::size_t lane, T (&into)[3][kLanes]) {
  for (std::size_t k = 0; k < 3; ++k) into[k][lane] = static_cast<T>(from[static_cast<Eigen::Index>(k)]);
}
template <class T>
Vec3 get(const T (&from)[3][kLanes], std::size_t lane) {
  return {static_cast<double>(from[0][lane]), static_cast<double>(from[1][lane]), static_cast<double>(from[2][lane])};
}

// What of a pair all its places share.
template <class T>
void fill_pair(const RestSystem& system, const RestPair& pair, std::size_t lane, RestBlock& block, PairLanes<T>& shared,
               StartLanes<T>& start) {
  const SolverBody& a = system.bodies[pair.a];
  const SolverBody& b = system.bodies[pair.b];
  const double unit_kg = 1.0 / (a.inverse_mass + b.inverse_mass);
  set(Vec3(system.poses[pair.b].position_m - system.poses[pair.a].position_m), lane, shared.a_to_b);
  shared.yield_a[lane] = static_cast<T>(unit_kg * a.inverse_mass);
  shared.yield_b[lane] = static_cast<T>(unit_kg * b.inverse_mass);
  shared.friction[lane] = static_cast<T>(pair.friction);
  shared.newton_s[lane] = static_cast<T>(unit_kg);
  set(Vec3(a.velocity_mps - b.velocity_mps), lane, start.velocity);
  set(a.spin_radps, lane, start.spin_a);
  set(b.spin_radps, lane, start.spin_b);
  start.restitution[lane] = static_cast<T>(pair.restitution);
  if (a.inverse_mass > 0) block.yields_a = static_cast<std::uint8_t>(block.yields_a | 1U << lane);
  if (b.inverse_mass > 0) block.yields_b = static_cast<std::uint8_t>(block.yields_b | 1U << lane);
  block.rubs = block.rubs || pair.friction > 0;
}

template <class T>
void fill_place(const RestSystem& system, const RestPair& pair, double per_unit, std::size_t place, std::size_t lane,
                PatchLanes<T>& into) {
  const PlaceNow now = place_now(system.poses[pair.a], system.poses[pair.b], system.places[place]);
  set(now.normal, lane, into.normal);
  set(now.arm_m, lane, into.arm);
  into.gap[lane] = static_cast<T>(now.gap_m);
  into.surely[lane] = static_cast<T>(now.surely_m + pair.slop_m);
  into.mass[lane] = 1;
  const RestLoad& load = system.loads[place];
  into.impulse[lane] = static_cast<T>(per_unit * load.impulse_ns);
  set(Vec3(per_unit * load.friction_ns), lane, into.rubbed);
}

}  // namespace

void fetch_pairs(const RestSystem& system, const RestBlock& block) {
  for (const std::uint32_t name : system.coloring.order().subspan(block.begin, block.count))
    hwy::Prefetch(&system.pairs[name]);
}

void fetch_places(const RestSystem& system, const RestBlock& block) {
  constexpr std::size_t kLine = 64;
  for (const std::uint32_t name : system.coloring.order().subspan(block.begin, block.count)) {
    const RestPair& pair = system.pairs[name];
    if (pair.place_count == 0) continue;
    const auto* place = reinterpret_cast<const std::byte*>(&system.places[pair.place_begin]);
    const std::size_t bytes = pair.place_count * sizeof(RestPlace);
    for (std::size_t at = 0; at < bytes; at += kLine) hwy::Prefetch(place + at);
    hwy::Prefetch(place + bytes - 1);
    hwy::Prefetch(&system.loads[pair.place_begin]);
    hwy::Prefetch(&system.loads[pair.place_begin + pair.place_count - 1U]);
    for (const std::uint32_t body : {pair.a, pair.b}) {
      hwy::Prefetch(&system.bodies[body]);
      hwy::Prefetch(&system.poses[body]);
      hwy::Prefetch(&system.poses[body].rotation(2, 2));
    }
  }
}

void fetch_loads(const RestSystem& system, const RestBlock& block) {
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    const RestPair& pair = system.pairs[block.pair[lane]];
    if (pair.place_count == 0) continue;
    hwy::Prefetch(&system.loads[pair.place_begin]);
    hwy::Prefetch(&system.loads[pair.place_begin + pair.place_count - 1U]);
    hwy::Prefetch(&system.given_ns[block.pair[lane]]);
  }
}

template <class T>
Gyration<T> gyration(const SolverBody& body, const Mat3& inverse_inertia) {
  Gyration<T> made;
  if (body.inverse_mass == 0) return made;
  const double kg = 1.0 / body.inverse_mass;
  const double parts[6] = {inverse_inertia(0, 0), inverse_inertia(1, 1), inverse_inertia(2, 2),
                           inverse_inertia(0, 1), inverse_inertia(0, 2), inverse_inertia(1, 2)};
  for (std::size_t k = 0; k < 6; ++k) made.inertia[k] = static_cast<T>(kg * parts[k]);
  return made;
}

template <class T>
void fill_block(const RestSystem& system, double still_mps, RestBlock& block, PairLanes<T>& shared, Lanes<T>& lanes) {
  const std::span<PatchLanes<T>> patches = lanes.patches_of(block);
  const std::span<const std::uint32_t> order = system.coloring.order().subspan(block.begin, block.count);
  shared = {};
  for (PatchLanes<T>& patch : patches) patch = {};
  StartLanes<T> start;
  block.yields_a = block.yields_b = block.pushed = 0;
  block.rubs = false;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    // Lanes that are not in use read what nobody else writes, and write nothing.
    const std::uint32_t name = order[std::min<std::size_t>(lane, block.count - 1U)];
    const RestPair& pair = system.pairs[name];
    block.pair[lane] = name;
    block.a[lane] = pair.a;
    block.b[lane] = pair.b;
    if (lane >= block.count) continue;
    fill_pair(system, pair, lane, block, shared, start);
    const SolverBody& a = system.bodies[pair.a];
    const SolverBody& b = system.bodies[pair.b];
    // Without a pull, what held the pair last time would add energy.
    const double per_unit = a.pulled || b.pulled ? a.inverse_mass + b.inverse_mass : 0.0;
    for (std::size_t p = 0; p < pair.place_count; ++p)
      fill_place(system, pair, per_unit, pair.place_begin + p, lane, patches[p]);
  }
  prepare_block(block, shared, start, static_cast<T>(still_mps), patches, lanes.gyrations.data());
}

template <class T>
void add_totals(const RestBlock& block, Lanes<T>& lanes) {
  for (PatchLanes<T>& patch : lanes.patches_of(block)) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t lane = 0; lane < kLanes; ++lane)
        patch.total[k][lane] += patch.impulse[lane] * patch.normal[k][lane] + patch.rubbed[k][lane];
    }
  }
}

template <class T>
void give_block(const RestSystem& system, const RestBlock& block, const PairLanes<T>& shared, Lanes<T>& lanes) {
  const std::span<const PatchLanes<T>> patches = lanes.patches_of(block);
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    const RestPair& pair = system.pairs[block.pair[lane]];
    const double unit_ns = static_cast<double>(shared.newton_s[lane]);
    Vec3 sum = Vec3::Zero();
    Vec3 moment_a = Vec3::Zero();
    for (std::size_t p = 0; p < pair.place_count; ++p) {
      const PatchLanes<T>& patch = patches[p];
      RestLoad& load = system.loads[pair.place_begin + p];
      load.impulse_ns = unit_ns * static_cast<double>(patch.impulse[lane]);
      load.friction_ns = unit_ns * get(patch.rubbed, lane);
      const Vec3 given = unit_ns * get(patch.total, lane);
      sum += given;
      moment_a += get(patch.arm, lane).cross(given);
    }
    system.given_ns[block.pair[lane]] = sum;
    const bool pushed = (std::uint32_t{block.pushed} >> lane & 1U) != 0;
    if (!pushed && sum.isZero(0) && moment_a.isZero(0)) continue;
    SolverBody& a = system.bodies[pair.a];
    SolverBody& b = system.bodies[pair.b];
    if (a.inverse_mass > 0) {
      a.velocity_mps -= a.inverse_mass * sum;
      a.spin_radps -= system.inverse_inertia[pair.a] * moment_a;
      a.answered = true;
    }
    if (b.inverse_mass > 0) {
      const Vec3 a_to_b = system.poses[pair.b].position_m - system.poses[pair.a].position_m;
      b.velocity_mps += b.inverse_mass * sum;
      b.spin_radps += system.inverse_inertia[pair.b] * (moment_a - a_to_b.cross(sum));
      b.answered = true;
    }
  }
}

template Gyration<float> gyration(const SolverBody&, const Mat3&);
template Gyration<double> gyration(const SolverBody&, const Mat3&);
template void fill_block(const RestSystem&, double, RestBlock&, PairLanes<float>&, Lanes<float>&);
template void fill_block(const RestSystem&, double, RestBlock&, PairLanes<double>&, Lanes<double>&);
template void add_totals(const RestBlock&, Lanes<float>&);
template void add_totals(const RestBlock&, Lanes<double>&);
template void give_block(const RestSystem&, const RestBlock&, const PairLanes<float>&, Lanes<float>&);
template void give_block(const RestSystem&, const RestBlock&, const PairLanes<double>&, Lanes<double>&);

}  // namespace poise::response
