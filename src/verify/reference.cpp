// SPDX-License-Identifier: MIT
#include "verify/reference.h"

#include <algorithm>
#include <utility>

#include "frame/stages.h"
#include "geometry/bvh/ball_tree.h"
#include "poise_assert.h"
#include "verify/reference_figures.h"

namespace poise::simulation {
namespace {

// Settled is what changes by less than 1e-10 of the largest impulse. The bound on sweeps is chosen: a pile of 2,000
// meshes needs 400 to 1,200.
constexpr solver::Stopping kConverged{1e-10, 50000};

using Column = std::vector<double> dynamics::BodyStore::*;
using dynamics::BodyStore;
constexpr std::array<Column, Reference::kColumns> kColumnsOfState = {
    &BodyStore::x_m,      &BodyStore::y_m,      &BodyStore::z_m,      &BodyStore::qw,     &BodyStore::qx,
    &BodyStore::qy,       &BodyStore::qz,       &BodyStore::vx_mps,   &BodyStore::vy_mps, &BodyStore::vz_mps,
    &BodyStore::wx_radps, &BodyStore::wy_radps, &BodyStore::wz_radps, &BodyStore::fx_n,   &BodyStore::fy_n,
    &BodyStore::fz_n,     &BodyStore::tx_nm,    &BodyStore::ty_nm,    &BodyStore::tz_nm};

// Puts the start of the frame in place of its end while it lives: state, memory of pairs, buffers.
class StartOfFrame {
 public:
  explicit StartOfFrame(WorldState& world) : world_(world), contact_(world.settings.contact) {
    exchange();
    std::swap(world.points, world.reference->points);
    // Polygons answer alike in every model; where balls are the surface, this one finds the balls that meet.
    world.settings.contact = ContactModel::Fitted;
  }
  ~StartOfFrame() {
    std::swap(world_.points, world_.reference->points);
    exchange();
    world_.settings.contact = contact_;
  }
  StartOfFrame(const StartOfFrame&) = delete;
  StartOfFrame& operator=(const StartOfFrame&) = delete;

 private:
  void exchange() {
    Reference& reference = *world_.reference;
    for (std::size_t i = 0; i < Reference::kColumns; ++i)
      std::swap(world_.bodies.*kColumnsOfState[i], reference.columns[i]);
    std::swap(world_.bodies.pushed, reference.pushed);
    // The step has left the memory that it started from where the next one will write.
    std::swap(world_.memory, world_.next_memory);
    std::swap(world_.buffers, reference.frame);
    // What workers write in is made once and lent to both.
    std::swap(world_.buffers.pools, reference.frame.pools);
    std::swap(world_.buffers.tallies, reference.frame.tallies);
  }

  WorldState& world_;
  ContactModel contact_;
};

double size_of_impulse(const FrameBuffers& frame, std::size_t k) {
  const solver::ContactRow* row = row_of(frame, k);
  const Vec3& applied_impulse_ns = frame.applied_impulse_ns[frame.coloring.order()[k]];
  return row != nullptr ? (row->impact_ns() + applied_impulse_ns).norm() : applied_impulse_ns.norm();
}

const collision::TrueSurface& surface_of(const WorldState& world, std::uint32_t slot) {
  return *world.reference->surfaces[world.shape_of[slot]];
}

// Made one after another: most scenes have few shapes.
void prepare_surfaces(WorldState& world) {
  std::vector<std::unique_ptr<collision::TrueSurface>>& surfaces = world.reference->surfaces;
  surfaces.resize(world.shapes.size());
  for (std::size_t slot = 0; slot < world.bodies.slot_count(); ++slot) {
    if (world.bodies.alive[slot] == 0) continue;
    const std::uint32_t shape = world.shape_of[slot];
    if (surfaces[shape]) continue;
    surfaces[shape] = std::make_unique<collision::TrueSurface>(collision::true_surface_of(*world.shapes[shape].shape));
  }
}

// Impulses of both, then the gaps of what the run answered. Both frames list the same pairs in the same order.
std::vector<ComparedPair> compared_pairs(WorldState& world, const View& view) {
  const FrameBuffers& run = world.reference->frame;
  const FrameBuffers& full = world.buffers;
  POISE_ASSERT(run.pairs.size() == full.pairs.size());
  std::vector<ComparedPair> pairs(run.pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].a = run.pairs[i].a;
    pairs[i].b = run.pairs[i].b;
  }
  const auto pair_of = [](const FrameBuffers& frame, std::size_t k) {
    return frame.manifolds[frame.coloring.order()[k]].pair;
  };
  for (std::size_t k = 0; k < run.manifolds.size(); ++k) pairs[pair_of(run, k)].run_ns = size_of_impulse(run, k);
  for (std::size_t k = 0; k < full.manifolds.size(); ++k)
    pairs[pair_of(full, k)].reference_ns = size_of_impulse(full, k);
  const double least_ns = least_impulse_ns(pairs);
  parallel::parallel_for(*world.executor, pairs.size(), 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      ComparedPair& pair = pairs[i];
      if (!touches(pair.run_ns, least_ns)) continue;
      pair.gap_m = collision::surface_distance_m(surface_of(world, pair.a), full.poses[pair.a],
                                                 surface_of(world, pair.b), full.poses[pair.b]);
      if (!view.present) continue;
      const solver::ContactPoint& place = world.reference->points.points[ContactCache::begin(run.pairs[i].memory.room)];
      const Vec3 point =
          full.poses[pair.a].position_m + solver::placed_point(full.poses[pair.a], full.poses[pair.b], place).arm_m;
      pair.gap_px = length_px(view, point, pair.gap_m);
    }
  });
  return pairs;
}

// Who stands between the viewer and a body.
class Occlusion {
 public:
  Occlusion(const WorldState& world, const View& view) : world_(world), view_(view) {
    std::vector<Sphere> balls;
    for (std::uint32_t slot = 0; slot < world.bodies.slot_count(); ++slot) {
      if (world.bodies.alive[slot] == 0) continue;
      if (world.bodies.shape[slot]->kind == ShapeKind::Plane) {
        planes_.push_back(slot);
        continue;
      }
      slots_.push_back(slot);
      balls.push_back({world.bodies.position(slot), world.bodies.shape[slot]->bounding_radius_m});
    }
    tree_ = geometry::BallTree(balls);
  }
  [[nodiscard]] bool hidden(std::uint32_t slot) const {
    const Vec3 center = world_.bodies.position(slot);
    const auto blocks = [&](std::uint32_t other) {
      if (other == slot) return false;
      const collision::Pose& pose = world_.buffers.poses[other];
      const Mat3 back = pose.rotation.transpose();
      return surface_of(world_, other)
          .blocks(back * (view_.position_m - pose.position_m), back * (center - pose.position_m));
    };
    return std::any_of(planes_.begin(), planes_.end(), blocks) ||
           tree_.any_along(view_.position_m, center, [&](std::uint32_t ball) { return blocks(slots_[ball]); });
  }

 private:
  const WorldState& world_;
  const View& view_;
  std::vector<std::uint32_t> planes_, slots_;
  geometry::BallTree tree_;
};

std::vector<ComparedBody> touched_bodies(WorldState& world, std::span<const ComparedPair> pairs, const View& view) {
  const dynamics::BodyStore& bodies = world.bodies;
  const FrameBuffers& run = world.reference->frame;
  const FrameBuffers& full = world.buffers;
  std::vector<std::uint8_t> touched(bodies.slot_count(), 0);
  const double least_ns = least_impulse_ns(pairs);
  for (const ComparedPair& pair : pairs) {
    if (touches(pair.run_ns, least_ns) || touches(pair.reference_ns, least_ns)) touched[pair.a] = touched[pair.b] = 1;
  }
  std::vector<ComparedBody> judged;
  for (std::uint32_t slot = 0; slot < touched.size(); ++slot) {
    if (touched[slot] == 0 || bodies.dynamic[slot] == 0) continue;
    ComparedBody body;
    body.slot = slot;
    body.dv_mps = run.solver_bodies[slot].velocity_mps - bodies.velocity(slot);
    body.dw_radps = run.solver_bodies[slot].spin_radps - bodies.spin(slot);
    body.reference_dv_mps = full.solver_bodies[slot].velocity_mps - bodies.velocity(slot);
    body.reference_dw_radps = full.solver_bodies[slot].spin_radps - bodies.spin(slot);
    body.inertia_per_mass_m2 = dynamics::inertia_world(bodies, slot) / bodies.mass_kg[slot];
    judged.push_back(body);
  }
  if (!view.present) return judged;
  const Occlusion occlusion(world, view);
  parallel::parallel_for(*world.executor, judged.size(), 16, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t slot = judged[i].slot;
      judged[i].weight =
          error_weight(view, bodies.position(slot), bodies.shape[slot]->bounding_radius_m, occlusion.hidden(slot));
    }
  });
  return judged;
}

}  // namespace

void remember(WorldState& world) {
  if (!world.reference) world.reference = std::make_unique<Reference>();
  Reference& reference = *world.reference;
  for (std::size_t i = 0; i < Reference::kColumns; ++i) reference.columns[i] = world.bodies.*kColumnsOfState[i];
  reference.pushed = world.bodies.pushed;
  reference.points = world.points;
}

ReferenceFigures refer(WorldState& world, const StepInput& input) {
  const TimePoint begun = SteadyClock::now();
  StepInput full = input;
  full.budget = Budget::unlimited();
  full.max_level = kMaxTreeDepth;
  full.polygons = true;
  FrameReport made;
  ReferenceFigures figures;
  {
    const StartOfFrame start(world);
    predict(world, full);
    find_pairs(world, full, made);
    // What a pair keeps is part of the run, not of the truth.
    for (ActivePair& pair : world.buffers.pairs) pair.cached = CacheUse::None;
    const std::size_t not_finest = refine_to_the_end(world);
    const solver::Convergence response = respond(world, full, made, kConverged);
    prepare_surfaces(world);
    const std::vector<ComparedPair> pairs = compared_pairs(world, input.view);
    const std::vector<ComparedBody> bodies = touched_bodies(world, pairs, input.view);
    figures = compare_frames(bodies, pairs, input.view.present);
    figures.pairs_not_finest = not_finest;
    figures.converged = response.reached;
    figures.iterations = response.iterations;
  }
  figures.time = SteadyClock::now() - begun;
  return figures;
}

}  // namespace poise::simulation
