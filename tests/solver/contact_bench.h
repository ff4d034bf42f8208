// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "solver/contact_solver.h"

namespace poise::solver {

/// Bodies and pairs at rest on each other; the contact points of a pair are given when it is added.
struct Bench {
  std::vector<SolverBody> bodies;
  std::vector<collision::Pose> poses;
  std::vector<Acceleration> accelerations;
  std::vector<Mat3> inverse_inertia;
  std::vector<Manifold> pairs;
  std::vector<ContactPoint> points;
  std::vector<ContactForce> forces;
  std::vector<Vec3> applied_impulse_ns;
  Coloring coloring;
  SolveSettings settings;
  ContactSolver solver;
  std::unique_ptr<parallel::Executor> executor = parallel::make_executor(ExecutorKind::Serial, 1);

  std::uint32_t add_body(double mass_kg, const Vec3& point_m = Vec3::Zero(), const Vec3& velocity = Vec3::Zero()) {
    SolverBody body;
    body.velocity_mps = velocity;
    body.inverse_mass = mass_kg > 0 ? 1 / mass_kg : 0;
    body.acceleration = static_cast<std::uint32_t>(accelerations.size());
    bodies.push_back(body);
    poses.push_back({point_m, Mat3::Identity()});
    Acceleration pull;
    if (mass_kg > 0) pull.linear_mps2 = settings.gravity_mps2;
    accelerations.push_back(pull);
    inverse_inertia.push_back(mass_kg > 0 ? Mat3(Mat3::Identity() / (0.4 * mass_kg)) : Mat3(Mat3::Zero()));
    return static_cast<std::uint32_t>(bodies.size() - 1);
  }
  // Adds a pair whose surfaces have this separation at points in the world.
  void add_pair(std::uint32_t a, std::uint32_t b, const Vec3& normal, std::vector<Vec3> points_m, double friction = 0,
                double gap_m = 0) {
    Manifold pair;
    pair.a = a;
    pair.b = b;
    pair.point_begin = static_cast<std::uint32_t>(points.size());
    pair.point_count = static_cast<std::uint8_t>(points_m.size());
    pair.friction = friction;
    pairs.push_back(pair);
    for (const Vec3& point : points_m) {
      points.push_back({normal, normal.dot(point + 0.5 * gap_m * normal - poses[b].position_m),
                        point - 0.5 * gap_m * normal - poses[a].position_m, 0});
      forces.emplace_back();
    }
  }
  ContactSystem system() {
    std::vector<Edge> edges;
    std::uint64_t point_count = 0;
    for (const Manifold& pair : pairs) {
      edges.push_back(
          {pair.a, pair.b, bodies[pair.a].inverse_mass > 0, bodies[pair.b].inverse_mass > 0, pair.point_count});
      point_count += pair.point_count;
    }
    coloring.color(edges, bodies.size());
    applied_impulse_ns.resize(pairs.size());
    return {bodies, accelerations, inverse_inertia,    poses,    pairs,
            points, forces,        applied_impulse_ns, coloring, point_count};
  }
  Convergence solve() { return solver.solve(system(), settings, *executor); }
  Vec3 momentum() const {
    Vec3 sum = Vec3::Zero();
    for (const SolverBody& body : bodies) {
      if (body.inverse_mass > 0) sum += body.velocity_mps / body.inverse_mass;
    }
    return sum;
  }
  // About the origin, of the bodies where they are after the step.
  Vec3 angular_momentum() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (bodies[i].inverse_mass == 0) continue;
      sum += (poses[i].position_m + bodies[i].moved_m).cross(bodies[i].velocity_mps) / bodies[i].inverse_mass +
             inverse_inertia[i].inverse() * bodies[i].spin_radps;
    }
    return sum;
  }
  double energy_j() const {
    double sum = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (bodies[i].inverse_mass == 0) continue;
      sum += 0.5 * bodies[i].velocity_mps.squaredNorm() / bodies[i].inverse_mass +
             0.5 * bodies[i].spin_radps.dot(inverse_inertia[i].inverse() * bodies[i].spin_radps);
    }
    return sum;
  }
};

// Boxes of 1 kg in a column, each on four contact points of the one below it.
inline void stack(Bench& bench, int boxes) {
  bench.settings.gravity_mps2 = Vec3(0, 0, -9.81);
  bench.add_body(0);
  for (int i = 0; i < boxes; ++i) {
    const double z_m = i;
    const auto box = bench.add_body(1, Vec3(0, 0, z_m + 0.5));
    bench.add_pair(box - 1, box, Vec3(0, 0, 1),
                   {{0.4, 0.4, z_m}, {-0.4, 0.4, z_m}, {-0.4, -0.4, z_m}, {0.4, -0.4, z_m}}, 0.5);
  }
}

}  // namespace poise::solver
