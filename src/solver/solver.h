// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/executor.h"
#include "solver/contact_point.h"
#include "solver/impact_row.h"

namespace poise::solver {

/// When sweeps end. By default after the few that a frame can pay for. With a share above 0 they are repeated until no
/// impulse changes by more than that share of the largest one, and at most max_sweeps times in a row.
struct Stopping {
  double share = 0;                  ///< >= 0
  std::uint32_t max_iterations = 1;  ///< >= 1; of the impacts, and of each substep
  [[nodiscard]] bool converges() const { return share > 0; }
};

/// How sweeps ended.
struct Convergence {
  bool reached = true;           ///< false: some sweeps were cut off at max_sweeps
  std::uint32_t iterations = 0;  ///< over the velocities of rows, in all
  std::uint64_t visits = 0;  ///< of places by resting contact, in all; one that is sped up counts kMixedVisitCost times
  bool cut_short = false;    ///< SolveSettings::visits ended sweeps of resting contact that more would have gone on
};

/// What a visit costs that is sped up and in double precision, in plain visits in single precision: 90 ns instead of 13
/// (docs/scheduling.md).
inline constexpr std::uint32_t kMixedIterationCost = 7;
/// Resting contact visits places in a substep at most so often, but each once: 60,000 times plainly, or a third of that
/// sped up.
inline constexpr std::uint32_t kPlainPointIterations = 60000;
inline constexpr std::uint32_t kMixedPointIterations = kPlainPointIterations / 3;
/// The same at their cost.
inline constexpr std::uint32_t kMaxPointIterations = kMixedIterationCost * kMixedPointIterations;

/// What every row of a step is solved with. SI units.
struct SolveSettings {
  double dt_s = 1.0 / 60.0;
  Vec3 gravity_mps2 = Vec3::Zero();
  int substeps = 2;
  Stopping stopping;
  std::uint32_t visits =
      kMaxPointIterations;  ///< of a substep at most, at their cost, but for one sweep; not where `stopping` converges
};

/// Speeds up to this do not count as motion of a contact: what gravity adds in a step, and rounding where there is
/// none.
inline double still_mps(const SolveSettings& settings) {
  constexpr double kRoundingMps = 1e-12;
  return std::max(settings.gravity_mps2.norm() * settings.dt_s, kRoundingMps);
}

/// External acceleration of one body in this step, gravity included: m/s^2 and rad/s^2.
struct Acceleration {
  Vec3 linear_mps2 = Vec3::Zero();
  Vec3 angular_radps2 = Vec3::Zero();
  [[nodiscard]] bool none() const { return linear_mps2.isZero(0) && angular_radps2.isZero(0); }
};

/// What a sweep looks at before it touches a row: small, because most sweeps leave most rows alone.
struct RowActivation {
  std::uint32_t a = 0, b = 0;
  bool fast = true;   ///< its bodies move fast enough against each other that it may need an answer
  bool ready = true;  ///< the row holds what an impact needs
};

/// Fills a row with what an impact needs when it is first looked at. Called by any worker, once a row.
class RowSource {
 public:
  virtual ~RowSource() = default;
  virtual void fill(std::size_t row) const = 0;
};

/// Buffers of the solver. Invariant: they only grow.
struct SolveScratch {
  std::vector<RowActivation> activations;  ///< one a row; made by solve_impacts where there is no RowSource
  std::vector<std::uint32_t> changed;      ///< one a body: the last round of impacts that changed its velocity, from 1
  std::vector<double> change_ns;  ///< one a row, where sweeps converge: by how much the last one changed its impulse
};

/// The bodies and rows of one step. `rows` are in the order of `coloring`; `points` and `places` are those of the rows.
struct System {
  std::span<SolverBody> bodies;
  std::span<ContactRow> rows;
  std::span<const PointContact> points;
  std::span<const ContactPoint> contact_points;
  std::span<const collision::Pose> poses;  ///< one a body; read for places only
  std::span<const Mat3> inverse_inertia;   ///< one a body, world frame; read for point contacts and friction only
  const Coloring& coloring;
  SolveScratch& scratch;
  const RowSource* source = nullptr;  ///< of rows whose gate is not ready; without it all are
};

/// Answers impacts, before forces act on the new velocities (Guendelman, Bridson and Fedkiw 2003): every row that
/// closes faster than gravity adds in a step gets one impulse lambda = (1 + e) v_c / K if the surfaces meet nearer to
/// this step's start than to the next one's, with e = 0 where the rebound would be slower than that; one that meets
/// later in the step and does not rebound is slowed so that it just touches. Rows with point contacts answer these one
/// by one instead (DO eq. 1-3). Sweeps are repeated while an impulse was needed, at most kImpactSweeps times or as
/// `stopping` says. Linear and angular momentum are kept; energy never grows. Point contacts are answered in the first
/// sweep alone. Interlocked bodies may close at one place while their mean parts: a place that overlaps beyond doubt
/// and closes fast enough to rebound gets an impulse of its own. With friction an impulse lambda brings one across it,
/// against the slip at the place of contact and at most the coefficient times lambda.
Convergence solve_impacts(const System& system, const SolveSettings& settings, parallel::Executor& executor);
inline constexpr std::uint32_t kImpactIterations = 8;

}  // namespace poise::solver
