// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "poise/scene/scene.h"

namespace poise::bench {

/// The start of every engine, taken from a Poise World before its first step: one kind of body made of spheres, in a
/// tray of planes, with one material.
struct PileScene {
  std::vector<BodyState> start;      ///< of each dynamic body
  std::vector<Sphere> spheres;       ///< of a body: relative to its centre of mass, in its principal axes
  double mass_kg = 0;                ///< of a body
  Vec3 inertia_kgm2 = Vec3::Zero();  ///< of a body, principal moments
  struct Wall {
    Vec3 normal = Vec3::UnitZ();  ///< unit, into the tray
    double offset_m = 0;          ///< the surface is normal . x = offset
  };
  std::vector<Wall> walls;
  double friction = 0;     ///< of a contact
  double restitution = 0;  ///< of a contact
  Vec3 gravity_mps2 = Vec3::Zero();
  double dt_s = 0;
};

/// One engine with its own pile. One thread at a time; step() may use `threads` threads.
struct Engine {
  std::string name;
  std::string version;  ///< with the precision of its numbers
  int threads = 1;
  std::function<void()> step;  ///< steps by PileScene::dt_s
  /// Writes as many entries as there are bodies, in the order of PileScene::start.
  std::function<void(std::span<BodyState>)> read_states;
  /// Makes the pile anew with its bodies in these states, so what follows depends on the states alone. Not of Poise.
  std::function<void(std::span<const BodyState>)> set_states;
  /// Iterations of its solver in each step from now on, >= 1. Not of Poise.
  std::function<void(int)> set_iterations;
};

/// Approach speed below which restitution is ignored, in engines that need one: Bullet's default.
inline constexpr double kBounceFromMps = 0.2;

/// A scene with one kind of body in one grid and a tray, at Poise's start. Refused: other scenes, and scenes that Poise
/// refuses.
Result<PileScene> pile_scene(const Scene& scene, std::uint64_t bodies);

/// Poise with every pair at its finest level in every frame: no budget.
Result<Engine> make_poise(const Scene& scene, std::uint64_t bodies, int threads);

/// btDiscreteDynamicsWorld, sequential impulses of 10 iterations (its default); a body is a compound of spheres.
Engine make_bullet(const PileScene& scene);

/// dWorldQuickStep of 20 iterations (its default). The spheres of a body are in a simple space inside one hash space,
/// or, if `flat`, all spheres of all bodies are in the hash space.
Engine make_ode(const PileScene& scene, bool flat);

}  // namespace poise::bench
