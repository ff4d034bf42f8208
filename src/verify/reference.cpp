// SPDX-License-Identifier: MIT
#include "verify/reference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "frame/ccd/swept.h"
#include "frame/run_frame.h"
#include "geometry/bvh/ball_tree.h"
#include "poise_assert.h"
#include "verify/reference_figures.h"

namespace poise::simulation {
namespace {

// Converged means that no impulse of an island changes by more than 1e-10 of its largest one, or that the second half
// of the iterations has changed velocities by no more than 1 % of what contacts change. Both limits are
// chosen; docs/reference.md measures them.
constexpr solver::Stopping kConverged{1e-10, 1U << 15U, 1e-2};

using dynamics::BodyStore;

const collision::TrueSurface& surface_of(const WorldState& world, const Reference& reference, std::uint32_t slot) {
  return *reference.surfaces[world.shape_of[slot]];
}

// Built one after another, since most scenes have few shapes.
void prepare_surfaces(const WorldState& world, Reference& reference) {
  std::vector<std::unique_ptr<collision::TrueSurface>>& surfaces = reference.surfaces;
  surfaces.resize(world.shapes.size());
  for (std::size_t slot = 0; slot < world.bodies.slot_count(); ++slot) {
    if (world.bodies.alive[slot] == 0) continue;
    const std::uint32_t shape = world.shape_of[slot];
    if (surfaces[shape]) continue;
    surfaces[shape] = std::make_unique<collision::TrueSurface>(collision::true_surface_of(*world.shapes[shape].shape));
  }
}

// The pairs of the reference with the impulses of a run (a Frame or another Reference) and of the reference; `of_run`
// as of pairs_of_run.
template <class Run>
std::vector<ComparedPair> impulses_of(const Run& run, std::span<const std::uint32_t> of_run, const Reference& full) {
  std::vector<ComparedPair> pairs(full.table.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].a = full.table.pairs[i].a;
    pairs[i].b = full.table.pairs[i].b;
  }
  for (std::size_t m = 0; m < run.manifolds.manifolds.size(); ++m)
    pairs[of_run[run.manifolds.manifolds[m].pair]].run_ns = run.velocities.impulse_ns(m).norm();
  for (std::size_t m = 0; m < full.manifolds.manifolds.size(); ++m)
    pairs[full.manifolds.manifolds[m].pair].reference_ns = full.velocities.impulse_ns(m).norm();
  return pairs;
}

// Impulses of run and reference, then the separations of the pairs that the run solved.
std::vector<ComparedPair> compared_pairs(const WorldState& world, Reference& full, const View& view) {
  const Frame& run = world.outputs;
  const std::vector<std::uint32_t> of_run = pairs_of_run(run.table, full.table);
  std::vector<ComparedPair> pairs = impulses_of(run, of_run, full);
  const parallel::UnsetVector<collision::Pose>& poses = run.motion.poses;
  const double least_ns = least_impulse_ns(pairs);
  parallel::parallel_for(*world.executor, of_run.size(), 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t of_table = begin; of_table < end; ++of_table) {
      const std::uint32_t i = of_run[of_table];
      ComparedPair& pair = pairs[i];
      if (!counts_as_touch(pair.run_ns, least_ns)) continue;
      if (std::isnan(full.gap_m[i])) {
        full.gap_m[i] = collision::surface_distance_m(surface_of(world, full, pair.a), poses[pair.a],
                                                      surface_of(world, full, pair.b), poses[pair.b]);
      }
      pair.gap_m = full.gap_m[i];
      if (!view.present) continue;
      const solver::PlacedPoint point = impact_point_of(run.motion, world.cache.points, run.table.pairs[of_table],
                                                        run.manifolds.points[of_table].slot);
      const Vec3 point_m = poses[pair.a].position_m + point.arm_m;
      pair.gap_px = length_px(view, point_m, pair.gap_m);
    }
  });
  return pairs;
}

// Whether another body is between the viewer and a body.
class Occlusion {
 public:
  Occlusion(const WorldState& world, const Reference& reference, const View& view)
      : world_(world), reference_(reference), bodies_(reference.bodies), view_(view) {
    std::vector<Sphere> balls;
    for (std::uint32_t slot = 0; slot < world.bodies.slot_count(); ++slot) {
      if (world.bodies.alive[slot] == 0) continue;
      if (world.bodies.shape[slot]->kind == ShapeKind::Plane) {
        planes_.push_back(slot);
        continue;
      }
      slots_.push_back(slot);
      balls.push_back({bodies_.position(slot), world.bodies.shape[slot]->bounding_radius_m});
    }
    tree_ = geometry::BallTree(balls);
  }
  [[nodiscard]] bool hidden(std::uint32_t slot) const {
    const Vec3 center = bodies_.position(slot);
    const auto blocks = [&](std::uint32_t other) {
      if (other == slot) return false;
      const collision::Pose& pose = world_.outputs.motion.poses[other];
      const Mat3 back = pose.rotation.transpose();
      return surface_of(world_, reference_, other)
          .blocks(back * (view_.position_m - pose.position_m), back * (center - pose.position_m));
    };
    return std::any_of(planes_.begin(), planes_.end(), blocks) ||
           tree_.any_along(view_.position_m, center, [&](std::uint32_t ball) { return blocks(slots_[ball]); });
  }

 private:
  const WorldState& world_;
  const Reference& reference_;
  const dynamics::BodyStore& bodies_;  // at the start of the frame
  const View& view_;
  std::vector<std::uint32_t> planes_, slots_;
  geometry::BallTree tree_;
};

// The bodies that a contact touched, with what `run` and the reference did to them.
std::vector<ComparedBody> touched_bodies(const WorldState& world, const Velocities& run, const Reference& reference,
                                         std::span<const ComparedPair> pairs) {
  const dynamics::BodyStore& bodies = reference.bodies;
  const Velocities& full = reference.velocities;
  std::vector<std::uint8_t> touched(bodies.slot_count(), 0);
  const double least_ns = least_impulse_ns(pairs);
  for (const ComparedPair& pair : pairs) {
    if (counts_as_touch(pair.run_ns, least_ns) || counts_as_touch(pair.reference_ns, least_ns))
      touched[pair.a] = touched[pair.b] = 1;
  }
  std::vector<ComparedBody> compared;
  for (std::uint32_t slot = 0; slot < touched.size(); ++slot) {
    if (touched[slot] == 0 || bodies.dynamic[slot] == 0) continue;
    ComparedBody body;
    body.slot = slot;
    body.dv_mps = body.dw_radps = Vec3::Zero();
    // What waits keeps its velocity.
    if (!run.bodies[slot].held && world.bodies.paused[slot] == 0) {
      body.dv_mps = run.bodies[slot].velocity_mps - bodies.velocity(slot);
      body.dw_radps = run.bodies[slot].spin_radps - bodies.spin(slot);
    }
    body.reference_dv_mps = full.bodies[slot].velocity_mps - bodies.velocity(slot);
    body.reference_dw_radps = full.bodies[slot].spin_radps - bodies.spin(slot);
    body.inertia_per_mass_m2 = dynamics::inertia_world(bodies, slot) / bodies.mass_kg[slot];
    compared.push_back(body);
  }
  return compared;
}

// How well a viewer sees these bodies.
void weigh(const WorldState& world, const View& view, Reference& reference, std::span<ComparedBody> compared) {
  if (!view.present) return;
  const dynamics::BodyStore& bodies = reference.bodies;
  const Occlusion occlusion(world, reference, view);
  parallel::parallel_for(*world.executor, compared.size(), 16, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t slot = compared[i].slot;
      double& weight = reference.weight[slot];
      if (std::isnan(weight))
        weight =
            error_weight(view, bodies.position(slot), bodies.shape[slot]->bounding_radius_m, occlusion.hidden(slot));
      compared[i].weight = weight;
    }
  });
}

}  // namespace

std::vector<std::uint32_t> pairs_of_run(const PairTable& run, const PairTable& full) {
  std::vector<std::uint32_t> of_run(run.size());
  std::uint32_t at = 0;
  for (std::size_t i = 0; i < of_run.size(); ++i) {
    while (full.pairs[at].id() != run.pairs[i].id()) ++at;
    of_run[i] = at;
  }
  return of_run;
}

void remember(const WorldState& world, Reference& reference) {
  for (std::size_t i = 0; i < BodyStore::kColumnsOfState.size(); ++i)
    reference.columns[i] = world.bodies.*BodyStore::kColumnsOfState[i];
  reference.pushed = world.bodies.pushed;
  reference.points = world.cache.points;
}

namespace {

// Restores the bodies at the start of the frame, after the caller's changes and waking.
void restore_bodies(const WorldState& world, Reference& reference) {
  reference.bodies = world.bodies;
  for (std::size_t i = 0; i < BodyStore::kColumnsOfState.size(); ++i)
    reference.bodies.*BodyStore::kColumnsOfState[i] = reference.columns[i];
  reference.bodies.pushed = reference.pushed;
  if (world.bodies.paused_count() == 0) return;
  // What waits would move if there were time.
  for (std::uint32_t slot = 0; slot < world.bodies.slot_count(); ++slot) {
    if (world.bodies.paused[slot] != 0) reference.bodies.wake(slot);
  }
}

// Computes the frame again from *coarse* on; the first two stages depend only on the start of the frame.
void run_full(const WorldState& world, const StepInput& input, std::span<collision::FrontPool> pools,
              const ReferenceContacts& contacts_of, Reference& reference) {
  parallel::Executor& executor = *world.executor;
  const SceneView scene{reference.bodies, world.shape_of, world.shapes, world.materials};
  StepTerms terms = terms_of(world.settings, input);
  terms.max_level = contacts_of.max_level;
  terms.polygons = contacts_of.polygons;
  // Polygons are solved in the same way by every model. If balls are the surface, this model finds the balls that
  // touch.
  terms.contact = ContactModel::Fitted;
  FrameReport report;
  const bool waits = world.bodies.paused_count() > 0;
  if (waits) {
    reference.motion.everything = true;
    predict({scene, terms}, reference.motion, executor);
    find_candidates({scene, reference.motion, {world.settings.max_partners, world.settings.max_pairs}},
                    reference.broad_phase, reference.candidates, executor);
  }
  const PredictedMotion& motion = waits ? reference.motion : world.outputs.motion;
  const CandidatePairs& candidates = waits ? reference.candidates : world.outputs.candidates;
  find_active_pairs({scene, terms, motion, candidates, world.cache.previous_pairs, world.pair_filter, true},
                    reference.table, pools, executor);
  // The contact cache belongs to the run, not to the reference.
  for (PairStart& pair : reference.table.start) pair.cached = CacheUse::None;
  begin_levels(reference.table, reference.levels, executor);
  const WorldSettings& settings = world.settings;
  const RefineInput refine_input{scene, terms,       motion,        reference.table,   settings.policy,
                                 input, world.frame, settings.seed, settings.substeps, settings.max_front_entries,
                                 {}};
  reference.not_finest = refine_to_the_end(refine_input, pools, reference.levels, executor);
  add_noise(contacts_of.noise, motion, reference.table, reference.levels);
  const SolveInput solve_input{
      scene,     terms, motion, reference.table, reference.levels, reference.manifolds, pools, settings.substeps,
      kConverged};
  make_manifolds({scene, terms, motion, reference.table, reference.levels, solver::still_mps(solve_input.settings())},
                 reference.points, reference.manifolds, report, executor);
  reference.velocities.everything = true;
  begin_solve(solve_input, reference.velocities, executor);
  const solver::Convergence impacts =
      solve_impacts(solve_input, reference.points, reference.velocities, report, executor);
  const solver::Convergence contacts = reference.island_solver.solve(
      contact_system(solve_input, reference.points, reference.velocities), solve_input.settings(), executor);
  if (terms.backtracking) {
    pools[0].clear();
    solve_swept(solve_input, reference.velocities, pools[0], report, executor);
  }
  reference.response.reached = impacts.reached && contacts.reached;
  reference.response.iterations = impacts.iterations + contacts.iterations;
}

}  // namespace

void make_reference(const WorldState& world, const StepInput& input, std::span<collision::FrontPool> pools,
                    Reference& reference, const ReferenceContacts& contacts) {
  restore_bodies(world, reference);
  run_full(world, input, pools, contacts, reference);
  prepare_surfaces(world, reference);
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  reference.gap_m.assign(reference.table.size(), kUnknown);
  reference.weight.assign(reference.bodies.slot_count(), kUnknown);
}

ReferenceFigures compare_with(const WorldState& world, const StepInput& input, Reference& reference,
                              std::vector<ComparedBody>* touched) {
  const std::vector<ComparedPair> pairs = compared_pairs(world, reference, input.view);
  std::vector<ComparedBody> bodies = touched_bodies(world, world.outputs.velocities, reference, pairs);
  weigh(world, input.view, reference, bodies);
  ReferenceFigures figures = compare_frames(bodies, pairs, input.view.present);
  figures.pairs_not_finest = reference.not_finest;
  figures.converged = reference.response.reached;
  figures.iterations = reference.response.iterations;
  if (touched != nullptr) *touched = std::move(bodies);
  return figures;
}

ReferenceFigures compare_references(const WorldState& world, const Reference& other, const Reference& reference) {
  const std::vector<ComparedPair> pairs = impulses_of(other, pairs_of_run(other.table, reference.table), reference);
  ReferenceFigures figures = compare_frames(touched_bodies(world, other.velocities, reference, pairs), pairs, false);
  figures.converged = other.response.reached && reference.response.reached;
  return figures;
}

ReferenceFigures refer(const WorldState& world, const StepInput& input, std::span<collision::FrontPool> pools,
                       Reference& reference) {
  const SteadyClock::time_point begun = SteadyClock::now();
  make_reference(world, input, pools, reference);
  ReferenceFigures figures = compare_with(world, input, reference);
  figures.time = SteadyClock::now() - begun;
  return figures;
}

}  // namespace poise::simulation
