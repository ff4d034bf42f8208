// SPDX-License-Identifier: MIT
#include "solver/iterations/energy_guard.h"

#include <Eigen/LU>

#include <algorithm>

namespace poise::solver {
namespace {

Vec3 of(const double (&parts)[3]) { return {parts[0], parts[1], parts[2]}; }

}  // namespace

void EnergyGuard::begin(const SplitSystem& system, std::span<const ContactBlock> blocks) {
  names_.clear();
  driven_ = false;
  for (const ContactBlock& block : blocks) {
    for (std::size_t lane = 0; lane < block.count; ++lane) {
      for (const std::uint32_t name : {block.a[lane], block.b[lane]}) {
        const SolverBody& body = system.body(name);
        if (body.inverse_mass > 0) names_.push_back(name);
        driven_ = driven_ || (body.inverse_mass == 0 && !(body.velocity_mps.isZero(0) && body.spin_radps.isZero(0)));
      }
    }
  }
  std::sort(names_.begin(), names_.end());
  names_.erase(std::unique(names_.begin(), names_.end()), names_.end());
  bodies_.clear();
  for (const std::uint32_t name : names_) {
    const SolverBody& body = system.body(name);
    bodies_.push_back(
        {name, 1 / body.inverse_mass, system.inverse_inertia_of(name).inverse(), body.velocity_mps, body.spin_radps});
  }
  fill_lanes();
}

void EnergyGuard::fill_lanes() {
  lanes_.assign((bodies_.size() + kLanes - 1) / kLanes, BodyEnergies{});
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    BodyEnergies& lanes = lanes_[i / kLanes];
    const std::size_t lane = lanes.count++;
    lanes.name[lane] = body.name;
    lanes.kg[lane] = body.kg;
    for (Eigen::Index row = 0; row < 3; ++row) {
      lanes.velocity_mps[row][lane] = body.velocity_mps[row];
      lanes.spin_radps[row][lane] = body.spin_radps[row];
      for (Eigen::Index column = 0; column < 3; ++column)
        lanes.inertia_kgm2[column][row][lane] = body.inertia_kgm2(row, column);
    }
  }
}

template <class Change>
EnergyGuard::Speed EnergyGuard::speed(const Body& body, const Change& change) {
  return {body.velocity_mps + of(change.v), body.spin_radps + of(change.w)};
}

EnergyGuard::Speed EnergyGuard::speed_alone(const SplitSystem& system, const Body& body,
                                            const SpeedChange<double>& begun, double h_s) {
  const Acceleration& pull = system.acceleration_of(body.name);
  const Speed before = speed(body, begun);
  return {before.velocity_mps + h_s * pull.linear_mps2, before.spin_radps + h_s * pull.angular_radps2};
}

// Twice the kinetic energy where both are the same.
double EnergyGuard::product(const Body& body, const Speed& a, const Speed& b) {
  return body.kg * a.velocity_mps.dot(b.velocity_mps) + a.spin_radps.dot(body.inertia_kgm2 * b.spin_radps);
}

double EnergyGuard::joules(std::span<const MotionChange<double>> changes) const {
  return kinetic_j(lanes_, changes.data());
}

double EnergyGuard::joules_alone(const SplitSystem& system, std::span<const SpeedChange<double>> begun,
                                 double h_s) const {
  double sum = 0;
  for (const Body& body : bodies_) {
    const Speed alone = speed_alone(system, body, begun[body.name], h_s);
    sum += 0.5 * product(body, alone, alone);
  }
  return sum;
}

double EnergyGuard::best_share(const SplitSystem& system, std::span<const SpeedChange<double>> begun, double h_s,
                               std::span<const MotionChange<double>> changes) const {
  if (driven_) return 1.0;
  // With a share s of the impulses the energy is that without, plus s times `slope`, plus s^2 / 2 times `bend`.
  double slope = 0;
  double bend = 0;
  for (const Body& body : bodies_) {
    const Speed alone = speed_alone(system, body, begun[body.name], h_s);
    const Speed now = speed(body, changes[body.name]);
    const Speed given = {now.velocity_mps - alone.velocity_mps, now.spin_radps - alone.spin_radps};
    slope += product(body, given, alone);
    bend += product(body, given, given);
  }
  return bend > 0 ? std::clamp(-slope / bend, 0.0, 1.0) : 1.0;
}

void EnergyGuard::scale(const SplitSystem& system, std::span<const SpeedChange<double>> begun, double h_s, double share,
                        std::span<MotionChange<double>> changes) const {
  for (const Body& body : bodies_) {
    const Speed alone = speed_alone(system, body, begun[body.name], h_s);
    MotionChange<double>& change = changes[body.name];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      const double without_v = alone.velocity_mps[at] - body.velocity_mps[at];
      const double without_w = alone.spin_radps[at] - body.spin_radps[at];
      change.v[k] = without_v + share * (change.v[k] - without_v);
      change.w[k] = without_w + share * (change.w[k] - without_w);
    }
  }
}

void EnergyGuard::keep(std::span<const MotionChange<double>> changes) {
  saved_.resize(std::max(saved_.size(), bodies_.size()));
  for (std::size_t i = 0; i < bodies_.size(); ++i) saved_[i] = changes[bodies_[i].name];
}

void EnergyGuard::restore(std::span<MotionChange<double>> changes) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) changes[bodies_[i].name] = saved_[i];
}

}  // namespace poise::solver
