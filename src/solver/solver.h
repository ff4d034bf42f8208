// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collision/manifold/manifold_point.h"
#include "parallel/executor.h"
#include "solver/coloring.h"
#include "solver/contacts/contact_point.h"
#include "solver/impacts/impact_row.h"

namespace poise::solver {

/// When iterations end. By default after the few that a frame has time for. With a share above 0 they go on until no
/// impulse changes by more than that share of the largest one, or until the velocities have settled (Settling), and at
/// most max_iterations times in a row.
struct Stopping {
  double share = 0;                  ///< >= 0
  std::uint32_t max_iterations = 1;  ///< >= 1; of the impacts, and of each substep
  double settled_share = 0;          ///< of resting contact, for Settling; 0: impulses alone decide
  [[nodiscard]] bool converges() const { return share > 0; }
};

/// How the iterations ended.
struct Convergence {
  bool reached = true;           ///< false: some were cut off at max_iterations
  std::uint32_t iterations = 0;  ///< over the velocities of rows, in all
  std::uint64_t point_iterations =
      0;                   ///< by resting contact, in all; one with extrapolation counts kMixedIterationCost times
  bool cut_short = false;  ///< SolveSettings::point_iterations ended resting contact before it had converged
};

/// Cost of one point iteration with extrapolation in double precision, in plain ones in single precision: 90 ns instead
/// of 13 (docs/scheduling.md).
inline constexpr std::uint32_t kMixedIterationCost = 7;
/// Point iterations of resting contact in a substep, at most, but at least one a contact point: 60,000 plain ones, or a
/// third of that with extrapolation.
inline constexpr std::uint32_t kPlainPointIterations = 60000;
inline constexpr std::uint32_t kMixedPointIterations = kPlainPointIterations / 3;
/// The same at their cost.
inline constexpr std::uint32_t kMaxPointIterations = kMixedIterationCost * kMixedPointIterations;

/// Parameters of the solver. SI units.
struct SolveSettings {
  double dt_s = 1.0 / 60.0;
  Vec3 gravity_mps2 = Vec3::Zero();
  int substeps = 2;
  Stopping stopping;
  std::uint32_t point_iterations = kMaxPointIterations;  ///< limit for a substep, at their cost, but at least one
                                                         ///< iteration; unused where `stopping` converges
  bool collide = false;  ///< bodies collide in this step: with the contact solver, iterations may be over-relaxed from
                         ///< the first on
  /// With the contact solver: no iteration but the first of a substep is begun that is not likely to end by then, by
  /// the clock of the executor.
  std::optional<std::chrono::steady_clock::time_point> until = std::nullopt;
  /// Likewise: so many iterations of each substep and no more, as another run was stopped after; 0: as many as without.
  std::span<const std::uint32_t> repeated = {};
};

/// How the iterations of the contact solver in a step were stopped by SolveSettings::until.
struct IterationsMade {
  std::vector<std::uint32_t> stopped_after;       ///< one a substep: how many it made; 0: it was not stopped
  std::chrono::nanoseconds beyond{0};             ///< time of all but the first of each substep
  std::chrono::steady_clock::time_point ended{};  ///< the last one
};

/// Approach speed below which a contact counts as at rest: what gravity adds in a step, or a rounding bound without
/// gravity.
inline double still_mps(const SolveSettings& settings) {
  constexpr double kRoundingMps = 1e-12;
  return std::max(settings.gravity_mps2.norm() * settings.dt_s, kRoundingMps);
}

/// An external acceleration of bodies in this step, gravity included: m/s^2 and rad/s^2.
struct Acceleration {
  Vec3 linear_mps2 = Vec3::Zero();
  Vec3 angular_radps2 = Vec3::Zero();
  [[nodiscard]] bool none() const { return linear_mps2.isZero(0) && angular_radps2.isZero(0); }
};

/// How a row answers when its bodies close.
enum class RowKind : std::uint8_t {
  Degenerate,  ///< not at all
  Wrench,      ///< by one impulse along its wrench
  Points,      ///< by point contacts one by one
};

/// What an iteration reads before it touches a row: small, because many looks end here.
struct RowActivation {
  std::uint32_t a = 0, b = 0;
  /// Contact points that certainly penetrate, if the manifold has several: of System::overlaps. Set by who fills the
  /// row.
  std::uint32_t overlaps_begin = 0;
  std::uint8_t overlap_count = 0;
  RowKind kind = RowKind::Wrench;
  bool fast = true;          ///< its bodies move fast enough relative to each other that it may need an impulse
  bool ready : 1 = true;     ///< the row holds what an impact needs
  bool bounces : 1 = false;  ///< out: it closes fast enough to rebound, and is left to the impact phase
};
static_assert(sizeof(RowActivation) == 16);

/// Notes that a row has been filled.
inline void activate(const ContactRow& row, RowActivation& gate) {
  gate.ready = true;
  gate.kind = row.points_begin < row.points_end ? RowKind::Points : RowKind::Wrench;
  if (row.wrench.effective_mass == 0) gate.kind = RowKind::Degenerate;
}

/// Fills a row with what an impact needs when it is first looked at. Called by any worker, once a row.
class RowSource {
 public:
  virtual ~RowSource() = default;
  virtual void fill(std::size_t row) const = 0;
};

/// Buffers of the solver. Invariant: they only grow.
struct SolveScratch {
  std::vector<RowActivation> activations;  ///< one a row; made by solve_impacts where there is no RowSource
  std::vector<std::uint32_t> changed;      ///< one a body: when impacts last changed its velocity; 0: never
  std::vector<std::uint8_t> needed;        ///< one a row behind Coloring::shared_begin: it may need an impulse
  std::vector<double>
      change_ns;  ///< one a row, where iterations converge: by how much the last one changed its impulse
};

/// Contact points that certainly penetrate, of a row at most.
inline constexpr std::size_t kOverlapsOfRow = collision::kMaxManifoldPoints;

/// The bodies and rows of one step. `rows` are in the order of `coloring`; `points` and `overlaps` are those of
/// the rows.
struct System {
  std::span<SolverBody> bodies;
  std::span<ContactRow> rows;
  std::span<const PointContact> points;
  std::span<const OverlapPoint> overlaps;
  std::span<const Mat3> inverse_inertia;  ///< one a body, world frame; read for points and friction only
  const Coloring& coloring;
  SolveScratch& scratch;
  const RowSource* source = nullptr;  ///< of rows that are not ready; null: all rows are
};

/// Solves impacts, before forces act on the new velocities (Guendelman, Bridson and Fedkiw 2003): every row that closes
/// faster than gravity adds in a step gets one impulse lambda = (1 + e) v_c / K if the surfaces meet nearer to this
/// step's start than to the next one's, with e = 0 where the rebound would be slower than that; one that meets later in
/// the step and does not rebound is slowed so that it just touches. Rows with point contacts solve these one by one
/// instead (DO eq. 1-3). Iterations are repeated while an impulse was needed, at most kImpactIterations times
/// (kImpactIterationsOfFew where there are few rows) or as `stopping` says. Linear and angular momentum are conserved;
/// energy never grows. Point contacts are solved in the first iteration only. Interlocked bodies may close at one
/// contact point while the mean separates: a contact point that certainly penetrates and closes fast enough to rebound
/// gets an impulse of its own. With friction an impulse lambda brings a tangential one, against the slip at the contact
/// point and at most the coefficient times lambda.
Convergence solve_impacts(const System& system, const SolveSettings& settings, parallel::Executor& executor);
/// Chosen: docs/response.md, "How many rounds of impacts".
inline constexpr std::uint32_t kImpactIterations = 16;
inline constexpr std::uint32_t kImpactIterationsOfFew = 32;  ///< of at most kFewRows rows
inline constexpr std::size_t kFewRows = 4096;

}  // namespace poise::solver
