// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "capture/block_writer.h"
#include "capture/bytes.h"
#include "capture/observe.h"
#include "poise/scene/scene.h"

// What a capture costs: on the thread of the frame (observe), and on its own (write). Before anything is timed, the
// poses of what is written are compared with those of the bodies.
namespace poise::capture {
namespace {

constexpr std::uint64_t kFrames = 60;

/// Jacks that fall onto each other, their header and frames.
struct Fall {
  Scene scene;
  std::unique_ptr<SceneRun> run;
  CaptureHeader header;
  std::vector<SeenFrame> frames;
  std::string problem;
};

Fall fall_of(std::uint64_t bodies) {
  Fall fall;
  Result<Scene> scene = read_scene(std::filesystem::path(POISE_SOURCE_DIR) / "scenes/jacks.json");
  if (!scene) return {{}, nullptr, {}, {}, scene.error().message};
  fall.scene = std::move(scene).value();
  SceneRunOptions options;
  options.bodies = bodies;
  Result<SceneRun> run = SceneRun::create(fall.scene, options);
  if (!run) return {{}, nullptr, {}, {}, run.error().message};
  fall.run = std::make_unique<SceneRun>(std::move(run).value());
  fall.header = header_of(fall.scene, *fall.run);
  FrameObserver observer(fall.scene, *fall.run, false);
  StepInput input;
  input.dt_s = fall.scene.dt_s;
  input.budget = Budget::work(10 * bodies);
  for (std::uint64_t k = 0; k < kFrames; ++k) {
    if (!fall.run->before_frame(k)) fall.problem = "a frame was refused";
    input.view = fall.run->view();
    SeenFrame frame;
    frame.facts = facts_of(fall.run->world().step(input), input.view, input.dt_s);
    if (!observer.observe(frame)) fall.problem = "a frame was refused";
    fall.frames.push_back(std::move(frame));
  }
  return fall;
}

bool is_right(const Fall& fall, std::size_t frame) {
  const SeenFrame& seen = fall.frames[frame];
  for (const SeenBody& body : seen.bodies) {
    const PackedPose packed = pack(body.pose, fall.header.position_step_m, fall.header.orientation_steps);
    const Pose pose = unpack(packed, fall.header.position_step_m, fall.header.orientation_steps);
    const double error_m = (pose.position_m - body.pose.position_m).cwiseAbs().maxCoeff();
    if (error_m > 0.51 * fall.header.position_step_m ||
        pose.orientation.angularDistance(body.pose.orientation) > orientation_error_rad(fall.header.orientation_steps))
      return false;
  }
  return seen.bodies.size() == fall.run->bodies().size();
}

// Contacts are listed once: what is timed of them is the copy.
void observe(benchmark::State& state) {
  const Fall fall = fall_of(static_cast<std::uint64_t>(state.range(0)));
  if (!fall.problem.empty() || !is_right(fall, kFrames - 1)) return state.SkipWithError("the capture is wrong");
  FrameObserver observer(fall.scene, *fall.run, state.range(1) != 0);
  SeenFrame frame;
  for (auto _ : state) {
    frame.new_bodies.clear();
    frame.bodies.clear();
    frame.contacts.clear();
    benchmark::DoNotOptimize(observer.observe(frame));
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

void write(benchmark::State& state) {
  const Fall fall = fall_of(static_cast<std::uint64_t>(state.range(0)));
  if (!fall.problem.empty() || !is_right(fall, kFrames - 1)) return state.SkipWithError("the capture is wrong");
  double bytes = 0;
  for (auto _ : state) {
    BlockWriter writer;
    std::string out;
    bool sound = writer.begin(fall.header, out).ok();
    const std::size_t before = out.size();
    for (const SeenFrame& frame : fall.frames) sound = sound && writer.add(frame, out).ok();
    bytes = static_cast<double>(out.size() - before);
    if (!sound || !writer.finish(0, false, out).ok()) return state.SkipWithError("the capture is refused");
  }
  const double body_frames = static_cast<double>(kFrames) * static_cast<double>(state.range(0));
  state.counters["bytes_each"] = bytes / body_frames;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(body_frames));
}

BENCHMARK(observe)->ArgNames({"bodies", "contacts"})->Args({1000, 0})->Args({10000, 0})->Args({10000, 1});
BENCHMARK(write)->ArgNames({"bodies"})->Arg(1000)->Arg(10000);

}  // namespace
}  // namespace poise::capture
