// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "peers/engine.h"

namespace poise::bench {

/// The pile of an engine, made anew for each start: nothing is left of what it did before, neither contacts nor the
/// order in which pairs were found.
template <class Pile>
class FreshPile {
 public:
  explicit FreshPile(PileScene scene) : scene_(std::move(scene)), pile_(std::make_unique<Pile>(scene_)) {}

  void set(std::span<const BodyState> states) {
    scene_.start.assign(states.begin(), states.end());
    pile_.reset();
    pile_ = std::make_unique<Pile>(scene_);
    if (iterations_) pile_->iterations(*iterations_);
  }
  void iterations(int count) {
    iterations_ = count;
    pile_->iterations(count);
  }
  void step() { pile_->step(); }
  void read(std::span<BodyState> states) const { pile_->read(states); }

 private:
  PileScene scene_;
  std::unique_ptr<Pile> pile_;
  std::optional<int> iterations_;
};

/// The functions of an engine whose name and version the caller sets.
template <class Pile>
Engine engine_of(const PileScene& scene) {
  const auto pile = std::make_shared<FreshPile<Pile>>(scene);
  Engine engine;
  engine.step = [pile] { pile->step(); };
  engine.read_states = [pile](std::span<BodyState> states) { pile->read(states); };
  engine.set_states = [pile](std::span<const BodyState> states) { pile->set(states); };
  engine.set_iterations = [pile](int count) { pile->iterations(count); };
  return engine;
}

}  // namespace poise::bench
