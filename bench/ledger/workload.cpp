// SPDX-License-Identifier: MIT
#include "ledger/workload.h"

#include <fmt/format.h>
#include <hwy/targets.h>

#include <array>
#include <chrono>
#include <filesystem>

#include "ledger/callgrind_switch.h"
#include "poise/scene/scene.h"

namespace poise::ledger {
namespace {

constexpr std::array kWorkloads{
    Workload{"jacks-falling", "jacks.json", "", 35, 10, 0},
    Workload{"jacks-at-rest", "jacks.json", "", 400, 10, 0},
    Workload{"jacks-wrench", "jacks.json", "wrench", 35, 10, 0},
    Workload{"jacks-sleeping", "jacks.json", "sleeping", 400, 20, 0},
    Workload{"jacks-in-order", "jacks.json", "deadline", 35, 10, 0},
    Workload{"jacks-ranked", "jacks.json", "deadline, ranked", 35, 10, 0},
    Workload{"pile-forming", "pile.json", "", 40, 6, 0},
    Workload{"pile-polygons", "pile.json", "polygons", 40, 3, 0},
    Workload{"pile-within-budget", "pile.json", "", 40, 6, 200},
    Workload{"cue-occlusion", "pile.json", "occlusion", 40, 6, 200},
    Workload{"cue-gap", "pile.json", "gap", 40, 6, 200},
    Workload{"cue-delay", "pile.json", "delay", 40, 6, 200},
    Workload{"cue-onset", "pile.json", "onset", 40, 6, 200},
    Workload{"cue-crowding", "pile.json", "crowding", 40, 6, 200},
    Workload{"cue-attention", "pile.json", "attention", 40, 6, 200},
    Workload{"cue-hysteresis", "pile.json", "hysteresis", 40, 6, 200},
    Workload{"cue-learning", "pile.json", "learning", 40, 6, 200},
    Workload{"no-touch", "pile.json", "no touch", 40, 6, 200},
    Workload{"no-eccentricity", "pile.json", "no eccentricity", 40, 6, 200},
    Workload{"no-closing", "pile.json", "no closing", 40, 6, 200},
    Workload{"gas", "gas.json", "", 40, 20, 0},
};

Result<SceneRun> create_run(const Workload& workload, StepInput& input) {
  const std::filesystem::path file =
      std::filesystem::path(POISE_SOURCE_DIR) / "bench" / "ledger" / "scenes" / workload.scene;
  const Result<Scene> scene = read_scene(file);
  if (!scene) return scene.error();
  SceneRunOptions options;
  options.world.threads = 1;
  options.world.executor = ExecutorKind::Serial;
  options.world.sleeping = workload.with == "sleeping";
  if (workload.with == "wrench") options.world.contact = ContactModel::Wrench;
  options.world.policy = scene.value().policy;
  // A host's cue is asked for of every pair, however much time there is.
  if (workload.with == "deadline, ranked")
    options.world.policy.cue.function = [](const scheduler::PairView&, void*) noexcept { return 1.0; };
  options.tree_cache = TreeCacheSettings{};
  options.tree_cache->folder = POISE_LEDGER_TREES;
  Result<SceneRun> run = SceneRun::create(scene.value(), options);
  if (!run) return run.error();
  input.dt_s = scene.value().dt_s;
  input.budget = workload.work_units > 0 ? Budget::work(workload.work_units) : Budget::unlimited();
  input.max_level = scene.value().max_level;
  input.polygons = workload.with == "polygons";
  return run;
}

// Switches a cue on or off for the counted frames: before them all workloads of a scene are alike.
Status switch_cue(const Workload& workload, World& world) {
  scheduler::Policy policy = world.settings().policy;
  const bool off = workload.with.starts_with("no ");
  const std::string_view name = off ? workload.with.substr(3) : workload.with;
  for (const auto& fields : {scheduler::policy_weights(), scheduler::policy_parameters()}) {
    for (const scheduler::PolicyField& field : fields) {
      if (field.name != name) continue;
      policy.*field.value = off ? 0.0 : 1.0;
      return world.set_policy(policy);
    }
  }
  return Done{};
}

void add(CountedUnits& units, const FrameReport& report) {
  units.frames += 1;
  units.bodies += static_cast<double>(report.bodies);
  units.candidate_pairs += static_cast<double>(report.candidate_pairs);
  units.expansions += static_cast<double>(report.work_refine);
  units.levels += static_cast<double>(report.jobs_done);
  units.contact_pairs += static_cast<double>(report.contact_pairs);
  units.point_iterations += static_cast<double>(report.point_iterations);
}

}  // namespace

std::span<const Workload> workloads() { return kWorkloads; }

Status prepare_trees() {
  StepInput unused;
  const Result<SceneRun> run = create_run(Workload{"trees", "pile.json"}, unused);
  return run ? Status(Done{}) : Status(run.error());
}

Result<CountedUnits> run_workload(const Workload& workload) {
  // The same kernels on every machine: those that valgrind supports.
  if ((hwy::SupportedTargets() & HWY_AVX2) == 0) return bad_input("this machine has no AVX2");
  hwy::SetSupportedTargetsForTest(HWY_AVX2);
  StepInput input;
  Result<SceneRun> run = create_run(workload, input);
  if (!run) return run.error();
  CountedUnits units;
  const std::uint64_t end = workload.warm_up + workload.frames;
  for (std::uint64_t frame = 0; frame < end; ++frame) {
    const Status added = run.value().before_frame(frame);
    if (!added) return added.error();
    input.view = run.value().view();
    if (frame == workload.warm_up) {
      const Status switched = switch_cue(workload, run.value().world());
      if (!switched) return switched.error();
      start_instrumentation();
    }
    const bool counted = frame >= workload.warm_up;
    // So far away that what is done does not depend on the machine.
    if (workload.with.starts_with("deadline")) input.budget = Budget::within(std::chrono::hours(1));
    if (counted) toggle_collection();
    const FrameReport report = run.value().world().step(input);
    if (counted) toggle_collection();
    if (report.status != StepStatus::Done) return bad_input(fmt::format("frame {} was refused", frame));
    if (counted) add(units, report);
  }
  // Polygons are charged in expansions but are not expansions.
  if (input.polygons) units.expansions = 0;
  return units;
}

}  // namespace poise::ledger
