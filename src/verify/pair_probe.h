// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "poise/world.h"

namespace poise::simulation {

/// Two bodies, and how their collisions are solved.
struct PairSettings {
  ShapePtr a, b;
  ContactModel contact = ContactModel::Wrench;
  double restitution = 0.5;     ///< in [0, 1]
  double density_kgpm3 = 1000;  ///< of both
};

/// Where both bodies of a pair are, and how they move.
struct PairState {
  BodyState a, b;
};

/// A level of both trees, or the polygons below the deepest one.
struct ProbeLevel {
  Level level = 0;  ///< kMaxTreeDepth with polygons: these come after the deepest level there is
  bool polygons = false;
  friend bool operator==(const ProbeLevel&, const ProbeLevel&) = default;
};

/// A step without a budget that refines as far as this level.
StepInput step_to(ProbeLevel level, double dt_s);

/// What a step would make of one pair.
struct PairAnswer {
  bool met = false;  ///< the level finds them near; otherwise nothing else is set
  Level level = 0;   ///< that was reached
  double gap_m = 0;  ///< that the pair would wait for, negative in overlap
  Vec3 dv_a_mps = Vec3::Zero(), dw_a_radps = Vec3::Zero();
  Vec3 dv_b_mps = Vec3::Zero(), dw_b_radps = Vec3::Zero();
};

/// What one pair costs on one core, in nanoseconds.
struct PairCost {
  double refine_ns = 0;    ///< from the two roots to the contact of the level
  double overlap_ns = 0;   ///< the overlap tests of that alone
  double response_ns = 0;  ///< from the contact to the impulse on both bodies
};

class PairStages;

/// Asks the stages of World::step about a pair, for studies and tests: the same broad phase, refinement, rows and
/// impulses, on one thread, with data of its own. Each call takes the length of a step, whose motion says what is near:
/// in (0, kMaxTimeStepS]. Invariant: its World holds exactly the two bodies, without gravity.
class PairProbe {
 public:
  PairProbe(PairProbe&&) noexcept;
  PairProbe& operator=(PairProbe&&) noexcept;
  ~PairProbe();

  /// Refused as World::add_material and World::add_body, and a shape that is none.
  static Result<PairProbe> make(const PairSettings& settings);

  /// The impulse at this level as if the surfaces met here and now, whatever gap the level believes in; the contacts of
  /// the paper's model are those that meet in this step. States as World::set_state takes them; one that it refuses is
  /// not met.
  PairAnswer answer(const PairState& state, ProbeLevel level, double dt_s);
  /// Does a step from here give the pair an impulse, at its own time?
  bool acts(const PairState& state, ProbeLevel level, double dt_s);

  /// Refines and solves all `states` of a pair at each level, `rounds` times in turn, and takes the medians of what
  /// one pair costs, a figure a level. CPU time of the calling thread. Refused as make; no state or round; more fronts
  /// than their capacity.
  static Result<std::vector<PairCost>> costs(const PairSettings& settings, std::span<const PairState> states,
                                             std::span<const ProbeLevel> levels, double dt_s, int rounds);

 private:
  explicit PairProbe(World world);
  static Result<World> world_of(const PairSettings& settings, std::span<const PairState> states,
                                std::uint32_t capacity);
  /// What counts as near: all that the level finds, or as in a step what may meet within it.
  enum class Reach : std::uint8_t { Found, Step };
  bool pose(const PairState& state, ProbeLevel level, double dt_s, Reach reach);
  PairAnswer solve(const PairState& state);

  World world_;
  std::unique_ptr<PairStages> stages_;
};

}  // namespace poise::simulation
