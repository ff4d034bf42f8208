// SPDX-License-Identifier: MIT
#include "response/rest_blocks.h"

#include <cstddef>

namespace poise::response {
namespace {

template <class T>
void set(const Vec3& from, std::size_t lane, T (&into)[3][kLanes]) {
  for (std::size_t k = 0; k < 3; ++k) into[k][lane] = static_cast<T>(from[static_cast<Eigen::Index>(k)]);
}

template <class T>
void set_side(const RestSystem& system, std::uint32_t slot, double unit_kg, std::size_t lane, SideLanes<T>& into) {
  const SolverBody& body = system.bodies[slot];
  const Mat3& inertia = system.inverse_inertia[slot];
  into.yield[lane] = static_cast<T>(unit_kg * body.inverse_mass);
  const double parts[6] = {inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), inertia(0, 2), inertia(1, 2)};
  for (std::size_t k = 0; k < 6; ++k) into.inertia[k][lane] = static_cast<T>(unit_kg * parts[k]);
  set(body.spin_radps, lane, into.spin);
}

}  // namespace

template <class T>
void fill_block(const RestSystem& system, double still_mps, RestBlock& block, Lanes<T>& lanes) {
  const std::span<PatchLanes<T>> patches = lanes.patches_of(block);
  const std::span<FrictionLanes<T>> friction = lanes.friction_of(block);
  PairLanes<T> pairs;
  bool rubs = false;
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    const RestPair& pair = system.pairs[block.pair[lane]];
    const SolverBody& a = system.bodies[pair.a];
    const SolverBody& b = system.bodies[pair.b];
    const double unit_kg = 1.0 / (a.inverse_mass + b.inverse_mass);
    set_side(system, pair.a, unit_kg, lane, pairs.a);
    set_side(system, pair.b, unit_kg, lane, pairs.b);
    set(pair.a_to_b_m, lane, pairs.a_to_b);
    set(Vec3(a.velocity_mps - b.velocity_mps), lane, pairs.velocity);
    pairs.restitution[lane] = static_cast<T>(pair.restitution);
    pairs.friction[lane] = static_cast<T>(pair.friction);
    pairs.newton_s[lane] = static_cast<T>(unit_kg);
    rubs = rubs || pair.friction > 0;
  }
  block.rubs = rubs && !friction.empty();
  for (std::size_t p = 0; p < block.patches; ++p) {
    PlaceLanes<T> places;
    PatchLanes<T>& into = patches[p];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      into.gap[lane] = into.surely[lane] = 0;
      if (lane >= block.count || p >= system.pairs[block.pair[lane]].patch_count) continue;
      const RestPair& pair = system.pairs[block.pair[lane]];
      const RestPatch& patch = system.patches[pair.patch_begin + p];
      set(patch.normal, lane, places.normal);
      set(patch.arm_m, lane, places.arm);
      into.gap[lane] = static_cast<T>(patch.gap_m);
      into.surely[lane] = static_cast<T>(patch.surely_m + pair.slop_m);
      // Without a load, what held the pair last time would add energy.
      if (system.accelerations[pair.a].none() && system.accelerations[pair.b].none()) continue;
      const double per_unit = system.bodies[pair.a].inverse_mass + system.bodies[pair.b].inverse_mass;
      places.impulse[lane] = static_cast<T>(per_unit * patch.impulse_ns);
      set(Vec3(per_unit * patch.friction_ns), lane, places.rubbed);
    }
    prepare_patch(pairs, places, static_cast<T>(still_mps), into, block.rubs ? &friction[p] : nullptr);
    // Pairs with fewer places leave the rest of their lanes without effect.
    for (std::size_t lane = 0; lane < block.count; ++lane) {
      if (p >= system.pairs[block.pair[lane]].patch_count) into.newton_s[lane] = 0;
    }
  }
}

template <class T>
void add_totals(const RestBlock& block, Lanes<T>& lanes) {
  for (PatchLanes<T>& patch : lanes.patches_of(block)) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) patch.total[lane] += patch.impulse[lane];
  }
  for (FrictionLanes<T>& rubbed : lanes.friction_of(block)) {
    for (std::size_t t = 0; t < 2; ++t) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) rubbed.total[t][lane] += rubbed.impulse[t][lane];
    }
  }
}

template <class T>
void give_block(const RestSystem& system, const RestBlock& block, Lanes<T>& lanes) {
  const std::span<const PatchLanes<T>> patches = lanes.patches_of(block);
  const std::span<const FrictionLanes<T>> friction = lanes.friction_of(block);
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    RestPair& pair = system.pairs[block.pair[lane]];
    SolverBody& a = system.bodies[pair.a];
    SolverBody& b = system.bodies[pair.b];
    Vec3 sum = Vec3::Zero();
    Vec3 moment_a = Vec3::Zero();
    Vec3 moment_b = Vec3::Zero();
    for (std::size_t p = 0; p < pair.patch_count; ++p) {
      RestPatch& patch = system.patches[pair.patch_begin + p];
      const double newton_s = static_cast<double>(patches[p].newton_s[lane]);
      patch.impulse_ns = newton_s * static_cast<double>(patches[p].impulse[lane]);
      Vec3 given = (newton_s * static_cast<double>(patches[p].total[lane])) * patch.normal;
      patch.friction_ns.setZero();
      if (!friction.empty() && pair.friction > 0) {
        const Tangents along = tangents(patch.normal);
        for (std::size_t t = 0; t < 2; ++t) {
          const double unit_ns = newton_s * static_cast<double>(friction[p].share[lane]);
          const Vec3& tangent = t == 0 ? along.first : along.second;
          patch.friction_ns += (unit_ns * static_cast<double>(friction[p].impulse[t][lane])) * tangent;
          given += (unit_ns * static_cast<double>(friction[p].total[t][lane])) * tangent;
        }
      }
      sum += given;
      moment_a += patch.arm_m.cross(given);
      moment_b += (patch.arm_m - pair.a_to_b_m).cross(given);
    }
    pair.impulse_ns = sum;
    const bool answered = !sum.isZero(0) || !moment_a.isZero(0) || !moment_b.isZero(0) || (std::uint32_t{block.pushed} >> lane & 1U) != 0;
    if (!answered) continue;
    if (a.inverse_mass > 0) {
      a.velocity_mps -= a.inverse_mass * sum;
      a.spin_radps -= system.inverse_inertia[pair.a] * moment_a;
      a.answered = true;
    }
    if (b.inverse_mass > 0) {
      b.velocity_mps += b.inverse_mass * sum;
      b.spin_radps += system.inverse_inertia[pair.b] * moment_b;
      b.answered = true;
    }
  }
}

template void fill_block(const RestSystem&, double, RestBlock&, Lanes<float>&);
template void fill_block(const RestSystem&, double, RestBlock&, Lanes<double>&);
template void add_totals(const RestBlock&, Lanes<float>&);
template void add_totals(const RestBlock&, Lanes<double>&);
template void give_block(const RestSystem&, const RestBlock&, Lanes<float>&);
template void give_block(const RestSystem&, const RestBlock&, Lanes<double>&);

}  // namespace poise::response
