// SPDX-License-Identifier: MIT
// Poise's scheduler with another library's geometry: this program links poise::scheduler and FCL, and nothing else of
// Poise. Knots of rings drift through each other. Every frame has a deadline and computes the distance of each pair of
// neighbours. Each pair can be computed at three levels, each more precise and more expensive:
//
//   level 0   bounding spheres          every pair, every frame: the mandatory part
//   level 1   boxes around the rings    1 unit of work
//   level 2   the triangle meshes       exact, some tens of units
//
// The scheduler decides which pairs are refined further, and stops in time for the work that follows (the tail): here,
// pushing apart the knots that touch. At the end a table shows the result of each deadline.
#include <fcl/fcl.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <thread>
#include <vector>

#include "poise/scheduler/miss_cause.h"
#include "poise/scheduler/refine_until.h"

namespace sched = poise::scheduler;
using Clock = std::chrono::steady_clock;
using Mesh = fcl::BVHModel<fcl::OBBRSSd>;
using Kind = sched::JobOutcome::Kind;

namespace {

constexpr int kBodies = 70;
constexpr int kFrames = 60;      // frames for each deadline
constexpr int kCheckEvery = 10;  // interval of frames whose results are compared with the exact ones
constexpr double kRingM = 0.5;   // radius of a ring
constexpr double kTubeM = 0.12;  // radius of its tube
constexpr double kReachM = 0.3;  // pairs of spheres nearer than this are neighbours
constexpr double kRadiusM = kRingM + kTubeM;
constexpr std::uint64_t kBoxUnits = 1;
constexpr std::uint64_t kMeshUnits = 40;  // approximate number of box tests; the cost of a unit is learned

// A ring of triangles.
std::shared_ptr<Mesh> ring_mesh() {
  constexpr int kAround = 16, kAcross = 6;
  std::vector<fcl::Vector3d> points;
  std::vector<fcl::Triangle> triangles;
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kAcross; ++j) {
      const double u = 2 * std::numbers::pi * i / kAround, v = 2 * std::numbers::pi * j / kAcross;
      const double r = kRingM + kTubeM * std::cos(v);
      points.emplace_back(r * std::cos(u), r * std::sin(u), kTubeM * std::sin(v));
      const auto at = [](int a, int b) { return static_cast<std::size_t>(a % kAround * kAcross + b % kAcross); };
      triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  auto mesh = std::make_shared<Mesh>();
  mesh->beginModel();
  mesh->addSubModel(points, triangles);
  mesh->endModel();
  return mesh;
}

// Two neighbours and a bound of their gap: an item of the scheduler. Only the thread that holds the item writes.
struct Pair {
  int a = 0, b = 0;
  int level = 0;
  double gap_m = 0;  // a lower bound of the true gap; 0: they touch, at the completed level
};

struct Scene {
  std::shared_ptr<Mesh> mesh = ring_mesh();
  fcl::Boxd box{2 * kRadiusM, 2 * kRadiusM, 2 * kTubeM};
  std::vector<fcl::Transform3d> pose = std::vector<fcl::Transform3d>(kBodies, fcl::Transform3d::Identity());
  std::vector<Pair> pairs;
};

// Sets the poses of a frame; every ring drifts and turns on its own path.
void move(Scene& scene, int frame) {
  for (int k = 0; k < kBodies; ++k) {
    const double t = 0.02 * frame + k;
    fcl::Transform3d& pose = scene.pose[static_cast<std::size_t>(k)];
    pose.translation() = fcl::Vector3d(2.0 * std::sin(1.3 * t + 2.1 * k), 2.0 * std::sin(0.9 * t + 0.7 * k),
                                       2.0 * std::cos(1.1 * t + k));
    pose.linear() = Eigen::AngleAxisd(t, fcl::Vector3d(std::sin(k), std::cos(k), 0.5).normalized()).toRotationMatrix();
  }
}

// Level 0, for all pairs: the mandatory part of a frame.
void find_neighbours(Scene& scene) {
  scene.pairs.clear();
  for (int a = 0; a < kBodies; ++a) {
    for (int b = a + 1; b < kBodies; ++b) {
      const double apart_m = (scene.pose[static_cast<std::size_t>(a)].translation() -
                              scene.pose[static_cast<std::size_t>(b)].translation())
                                 .norm();
      if (apart_m < 2 * kRadiusM + kReachM) scene.pairs.push_back({a, b, 0, std::max(0.0, apart_m - 2 * kRadiusM)});
    }
  }
}

double gap_of(const Scene& scene, const fcl::CollisionGeometryd& geometry, const Pair& pair) {
  fcl::DistanceResultd result;
  const double gap_m = fcl::distance(&geometry, scene.pose[static_cast<std::size_t>(pair.a)], &geometry,
                                     scene.pose[static_cast<std::size_t>(pair.b)], fcl::DistanceRequestd(), result);
  return std::max(0.0, gap_m);
}

double exact_gap(const Scene& scene, const Pair& pair) { return gap_of(scene, *scene.mesh, pair); }

// The order of refinement is this program's choice: pairs that may touch and cost little come first. The unit of the
// score is free; the scheduler distinguishes scores by quarters of an octave.
std::uint32_t band_of(const Pair& pair) {
  const double units = static_cast<double>(pair.level == 0 ? kBoxUnits : kMeshUnits);
  return sched::octave_band(1.0 / ((pair.gap_m + 0.05) * units));
}

// Refines one pair by one level: the job that the scheduler calls, on any thread.
sched::JobOutcome refine(const Scene& scene, Pair& pair) {
  const bool touched = pair.gap_m == 0;
  const bool boxes = pair.level == 0;
  pair.gap_m = boxes ? std::max(pair.gap_m, gap_of(scene, scene.box, pair)) : exact_gap(scene, pair);
  ++pair.level;
  sched::JobOutcome outcome;
  outcome.kind = boxes ? Kind::Completed : Kind::Done;
  outcome.units = boxes ? kBoxUnits : kMeshUnits;
  outcome.next_units = kMeshUnits;
  outcome.next_band = band_of(pair);
  // The pair is separated: the tail has one pair less to push, and its time is available to refinement immediately.
  if (touched && pair.gap_m > 0) outcome.tail_items = -1;
  return outcome;
}

// The tail of a frame: pushes touching pairs apart. Returns the sum, so that no compiler removes the work.
double push_apart(const Scene& scene) {
  double pushed = 0;
  for (const Pair& pair : scene.pairs) {
    if (pair.gap_m > 0) continue;
    for (int sweep = 0; sweep < 20; ++sweep) pushed += 1.0 / (1.0 + std::hypot(pair.a, pair.b, sweep));
  }
  return pushed;
}

// CPU time of the calling thread. Wall time beyond it was taken by the system.
sched::Nanoseconds cpu_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + sched::Nanoseconds(time.tv_nsec);
}

// The result of one deadline.
struct Row {
  std::array<int, 6> late{};  // frames by MissCause
  int checked = 0;
  std::array<std::uint64_t, 3> at_level{};
  double error_m = 0, pushed = 0;
  bool wrong = false;
  sched::RefineCounts counts;
};

// State that the host keeps across frames: the forecast of its tail over its own features, the margin of that forecast,
// and the cost of a unit of its work.
struct Learned {
  static constexpr std::array<sched::ForecastFeature, 2> kTail{{{"constant", 30}, {"touching_pairs_k", 500}}};
  sched::LinearForecast tail{kTail};
  sched::TrackedQuantile margin{0.01};
  sched::UnitCost unit{2000};
  sched::RefineQueue queue;
};

void run_frame(Scene& scene, Learned& learned, int frame, double deadline_ms, Row& row) {
  const auto start = Clock::now();
  const auto cpu_start = cpu_time();
  move(scene, frame);
  find_neighbours(scene);
  const auto items = static_cast<std::uint32_t>(scene.pairs.size());
  const auto touching = std::ranges::count_if(scene.pairs, [](const Pair& pair) { return pair.gap_m == 0; });
  learned.queue.begin_frame(items, touching);
  for (std::uint32_t item = 0; item < items; ++item) learned.queue.add(item, band_of(scene.pairs[item]), kBoxUnits);

  const auto deadline = start + std::chrono::microseconds(static_cast<int>(1000 * deadline_ms));
  sched::FrameBudget budget = sched::make_frame_budget(deadline, sched::Nanoseconds(0), learned.tail, learned.margin,
                                                       std::array{1.0, 0.0}, 1, 1e-3, learned.unit.ns());
  budget.limited = deadline_ms > 0;
  // An engine would use its own threads; two are enough here.
  const auto refining = Clock::now();
  std::array<sched::RefineCounts, 2> counts;
  std::array<sched::Nanoseconds, 2> off_cpu{};
  const auto work = [&](std::size_t thread) {
    const auto cpu_begun = cpu_time();
    counts[thread] = sched::refine_until(
        learned.queue, budget, kMeshUnits, [] { return Clock::now(); },
        [&](std::uint32_t item, std::uint64_t) { return refine(scene, scene.pairs[item]); });
    off_cpu[thread] = Clock::now() - refining - (cpu_time() - cpu_begun);
  };
  std::jthread other(work, 1);
  work(0);
  const auto waiting = Clock::now();
  other.join();
  const sched::Nanoseconds waited = Clock::now() - waiting;
  sched::RefineCounts all = counts[0];
  all.add(counts[1]);
  row.pushed += push_apart(scene);
  const auto end = Clock::now();

  // The tail is everything after the last job, including the wait for the other thread.
  const sched::Nanoseconds tail = end - all.ended;
  const std::uint64_t touch = learned.queue.tail_items();
  learned.margin.observe(tail, budget.tail_forecast(touch));
  learned.tail.learn(std::array{1.0, 1e-3 * static_cast<double>(touch)}, tail);
  learned.unit.learn(all, budget.job_overhead_ns);

  // Finds the cause of a late frame. Own waiting is not time taken by the system, unless the system held up the thread
  // that is waited for.
  sched::LatenessFacts facts;
  facts.lateness = budget.limited ? end - deadline : sched::Nanoseconds(0);
  facts.budget = deadline - start;
  facts.off_cpu = end - start - (cpu_time() - cpu_start) - waited + std::min(waited, off_cpu[1]);
  facts.mandatory = refining - start + tail - facts.off_cpu;
  facts.longest_overrun = all.overrun;
  ++row.late[static_cast<std::size_t>(sched::classify(facts))];
  row.counts.add(all);
  for (const Pair& pair : scene.pairs) ++row.at_level[static_cast<std::size_t>(pair.level)];
  if (frame % kCheckEvery != 0) return;
  for (const Pair& pair : scene.pairs) {
    const double error_m = std::abs(pair.gap_m - exact_gap(scene, pair));
    row.wrong = row.wrong || (pair.level == 2 && error_m != 0);
    row.error_m += error_m;
    ++row.checked;
  }
}

}  // namespace

int main() {
  Scene scene;
  Learned learned;
  bool good = true;
  std::uint64_t exact = 0;
  std::printf("                  late by                       answered at level            error\n");
  std::printf("deadline  frames  infeasible machine overrun forecast  spheres  boxes  exact  mean\n");
  Row warm_up;  // lets the forecasts learn the costs on this machine
  for (int frame = 0; frame < kFrames; ++frame) run_frame(scene, learned, frame, 2.0, warm_up);
  for (const double deadline_ms : {0.5, 1.0, 2.0, 4.0, 8.0, 0.0}) {  // 0: none
    Row row;
    for (int frame = 0; frame < kFrames; ++frame) run_frame(scene, learned, frame, deadline_ms, row);
    const auto [spheres, boxes, meshes] = row.at_level;
    const std::uint64_t pairs = spheres + boxes + meshes;
    const auto percent = [&](std::uint64_t count) {
      return 100.0 * static_cast<double>(count) / static_cast<double>(pairs);
    };
    std::printf("%5.1f ms  %6d  %10d %7d %7d %8d  %6.1f%% %5.1f%% %5.1f%%  %.2f mm\n", deadline_ms, kFrames,
                row.late[1], row.late[2], row.late[3], row.late[4], percent(spheres), percent(boxes), percent(meshes),
                1000 * row.error_m / row.checked);
    exact += meshes;
    // Checks: the completed levels are those that the scheduler counted, an exact result is exact, and without a
    // deadline all pairs are refined.
    if (row.counts.jobs != boxes + 2 * meshes || row.wrong || !(row.pushed > 0)) good = false;
    if (deadline_ms == 0 && (meshes != pairs || row.error_m != 0)) good = false;
  }
  if (exact == 0) good = false;
  std::printf("%s\n", good ? "all answers are accounted for" : "WRONG: an answer is missing or not what it says");
  return good ? 0 : 1;
}
