// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "collision/triangles/true_surface.h"
#include "dynamics/body_store.h"
#include "frame/broad_phase_stage.h"
#include "frame/cues/prepared_cues.h"
#include "frame/frame.h"
#include "frame/refine/open_refinement.h"
#include "frame/sleeping.h"
#include "frame/sliced_step.h"
#include "parallel/built_once.h"
#include "parallel/executor.h"
#include "poise/world.h"
#include "query/body_index.h"
#include "solver/island_solver.h"
#include "world/contact_cache.h"
#include "world/decision_log.h"
#include "world/forecasts.h"
#include "world/learned_gains.h"

namespace poise::simulation {

/// What the reference of a frame works on (verify/reference.h), all of it its own. A World that never asks for one has
/// none.
struct Reference {
  std::array<std::vector<double>, dynamics::BodyStates::kColumns> columns;  ///< of the bodies at the start of the frame
  std::vector<std::uint8_t> pushed;
  PointCache points;  ///< of the start of the frame
  dynamics::BodyStore bodies;
  PredictedMotion motion;       ///< if bodies wait that the run did not look at; and
  BroadPhaseState broad_phase;  ///< likewise; and
  CandidatePairs candidates;    ///< likewise
  PairTable table;
  CompletedLevels levels;
  Manifolds manifolds;
  Velocities velocities;
  solver::IslandSolver island_solver;
  std::vector<std::unique_ptr<collision::TrueSurface>> surfaces;  ///< one a shape, made when it is first asked for
  std::vector<double> gap_m;                                      ///< one a pair, likewise: NaN where nobody has asked
  std::vector<double> weight;                                     ///< one a body, likewise
  std::size_t not_finest = 0;                                     ///< pairs that are not at their finest level
  solver::Convergence response;
};

/// Everything that a World holds: what lasts, in parts that are given one by one to the stage that may change them
/// (frame/run_frame.cpp), and the outputs of the last frame.
struct WorldState {
  WorldState() = default;
  WorldState(const WorldState&) = delete;
  WorldState& operator=(const WorldState&) = delete;
  ~WorldState() {
    end_sliced_step(*this);
    sliced.reset();
    settle();
  }
  /// Waits for workers that the last refinement abandoned: before anything changes that they read.
  void settle() const {
    if (executor) executor->settle();
  }
  /// Is a step unfinished, whose stages write their outputs?
  [[nodiscard]] bool in_slices() const { return sliced && sliced->task.unfinished(); }
  /// That have ended. The same in a step whatever frame it is in.
  [[nodiscard]] std::uint64_t steps() const { return frame - frames_without_step; }
  [[nodiscard]] SceneView scene() const { return {bodies, shape_of, shapes, materials}; }
  [[nodiscard]] SleepAccess sleep_access() { return {bodies, cache, sleeping}; }

  WorldSettings settings;
  std::unique_ptr<parallel::Executor> executor;

  // The scene
  dynamics::BodyStore bodies;
  std::vector<std::uint32_t> shape_of;  // per slot: index into shapes
  std::vector<ShapeFacts> shapes;
  std::vector<Material> materials;
  std::vector<std::uint8_t> material_removed;  // one a material
  PairFilter pair_filter;
  std::uint64_t frame = 0;                           // steps done, or begun and not ended yet
  std::uint64_t frames_unfinished = 0;               // of these, the last ones, whose step has not ended
  std::uint64_t frames_without_step = 0;             // of all, those in which no step ended
  std::uint64_t changes = 1;                         // of where bodies are and which there are: what queries go by
  parallel::BuiltOnce<query::BodyIndex> body_index;  // made by the first query

  // What lasts from frame to frame
  ContactCache cache;
  BodyChanges body_changes;
  ContactEvents events;
  SleepingState sleeping;
  BroadPhaseState broad_phase;
  Forecasts forecasts;
  LearnedGains learned;
  std::unique_ptr<DecisionLog> decisions;  // once a step was recorded

  std::unique_ptr<SlicedStep> sliced;  // once a step needed slices

  // The last frame
  Frame outputs;
  parallel::BuiltOnce<std::vector<Contact>> contacts;  // of the last step, made when somebody asks
  std::uint64_t contacts_version = 0;                  // of what contacts are made from; 0: there was no step

  // Memory that stages work in
  std::vector<collision::FrontPool> pools;  // one a worker: fronts
  scheduler::PriorityBands bands;
  scheduler::RoundSelector rounds;
  OpenRefinement open;
  PreparedCues prepared_cues;
  solver::ContactSolver contact_solver;
  std::unique_ptr<collision::FrontPool> swept_pool;  // for backtracking in *solve*, once it was asked for
  std::unique_ptr<Reference> reference;
};

/// Finds what is surely inside the shapes, once the policy asks for what hides what: not within a step.
void find_inner_solids(WorldState& world);

}  // namespace poise::simulation
