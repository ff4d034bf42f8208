// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "poise/world.h"

namespace poise::simulation {

/// Two bodies, and the parameters of their collision.
struct PairSettings {
  ShapePtr a, b;
  ContactModel contact = ContactModel::Wrench;
  double restitution = 0.5;     ///< in [0, 1]
  double density_kgpm3 = 1000;  ///< of both
};

/// Positions and velocities of both bodies of a pair.
struct PairState {
  BodyState a, b;
};

/// A level of both trees, or the polygons after the deepest level.
struct ProbeLevel {
  Level level = 0;  ///< kMaxTreeDepth with polygons, which follow the deepest level
  bool polygons = false;
  friend bool operator==(const ProbeLevel&, const ProbeLevel&) = default;
};

/// The input of a step without a budget that refines up to this level.
StepInput step_to(ProbeLevel level, double dt_s);

/// The result of a step for one pair.
struct PairImpulse {
  bool met = false;  ///< the level finds the pair near; if false, nothing else is set
  Level level = 0;   ///< the completed level
  double gap_m = 0;  ///< separation that the pair would wait for, negative in overlap
  Vec3 dv_a_mps = Vec3::Zero(), dw_a_radps = Vec3::Zero();
  Vec3 dv_b_mps = Vec3::Zero(), dw_b_radps = Vec3::Zero();
};

/// Cost of one pair on one core, in nanoseconds.
struct PairCost {
  double refine_ns = 0;    ///< from the two roots to the contact of the level
  double overlap_ns = 0;   ///< the overlap tests of that alone
  double response_ns = 0;  ///< from the contact to the impulse on both bodies
};

class PairStages;

/// Runs the stages of World::step on a single pair, for studies and tests: the same broad phase, refinement, rows and
/// impulses, on one thread, with its own data. Each call takes the length of a step, in (0, kMaxTimeStepS]; the motion
/// in the step determines which pairs are near. Invariant: its World holds exactly the two bodies, without gravity.
class PairProbe {
 public:
  PairProbe(PairProbe&&) noexcept;
  PairProbe& operator=(PairProbe&&) noexcept;
  ~PairProbe();

  /// Refused as World::add_material and World::add_body, and if a shape is null.
  static Result<PairProbe> make(const PairSettings& settings);

  /// The impulse at this level as if the surfaces met now, whatever separation the level estimates. With the paper's
  /// model only the contacts that close in this step act. States as for World::set_state; for a refused state `met` is
  /// false.
  PairImpulse impulse(const PairState& state, ProbeLevel level, double dt_s);
  /// Whether a step from this state gives the pair an impulse, at its own time of impact.
  bool acts(const PairState& state, ProbeLevel level, double dt_s);

  /// Refines and solves all `states` of a pair at each level, `rounds` times in turn, and returns the medians of the
  /// cost of one pair, one entry a level. CPU time of the calling thread. Refused: as make; no states or rounds; fronts
  /// beyond the capacity.
  static Result<std::vector<PairCost>> costs(const PairSettings& settings, std::span<const PairState> states,
                                             std::span<const ProbeLevel> levels, double dt_s, int rounds);

 private:
  explicit PairProbe(World world);
  static Result<World> world_of(const PairSettings& settings, std::span<const PairState> states,
                                std::uint32_t capacity);
  /// Which pairs count as near: all that the level finds, or as in a step those that may meet within it.
  enum class Reach : std::uint8_t { Found, Step };
  bool pose(const PairState& state, ProbeLevel level, double dt_s, Reach reach);
  PairImpulse solve(const PairState& state);

  World world_;
  std::unique_ptr<PairStages> stages_;
};

}  // namespace poise::simulation
