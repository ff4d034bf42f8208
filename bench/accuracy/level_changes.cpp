// SPDX-License-Identifier: MIT
#include "accuracy/level_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "accuracy/scene_watch.h"
#include "accuracy/small_world.h"

namespace poise::accuracy {
namespace {

constexpr double kSettleS = 15, kWatchS = 60;

/// How the levels of a settled pile change.
enum class Way { Full, RandomLevels, RandomPairs, Every10, Every60, RootsOnly };

const char* name_of(Way way) {
  switch (way) {
    case Way::RandomLevels:
      return "random levels every frame";
    case Way::RandomPairs:
      return "random levels of the pairs";
    case Way::Every10:
      return "budget none and full every 10 frames";
    case Way::Every60:
      return "budget none and full every 60 frames";
    case Way::RootsOnly:
      return "level 0 alone";
    default:
      return "full levels";
  }
}

// What a heap may do: its energy over the running minimum, in m g R per body, and the difference of its mean height to
// that at full levels.
struct Bounds {
  double excess = 1e-3, speed_mps = 0.2, height = 0.1;
};

// Of the median of some heaps, and of each.
struct Heaps {
  Bounds median, each;
};

// What is not that of a body at rest was measured (docs/accuracy.md, "Bounds that were measured").
struct Pile {
  const char* file;
  std::uint64_t bodies;
  double friction;
  Heaps served;   // full levels, any level for all pairs, ten frames without budget and ten with, in turn
  Heaps starved;  // a small share of what it would need, or a second without any
  Heaps roots;    // level 0 alone
};

const Heaps& bounds_of(const Pile& pile, Way way) {
  if (way == Way::RootsOnly) return pile.roots;
  return way == Way::RandomPairs || way == Way::Every60 ? pile.starved : pile.served;
}

struct Found {
  double excess = 0;  // of the energy over its running minimum, in m g R per body
  double largest_mps = 0;
  double height_m = 0;  // mean height of the centres, at the end
  std::size_t outside = 0;
};

// Sets the levels and budget of frame i after settling.
void set_levels(SceneWatch& watch, Way way, std::uint64_t i, std::uint64_t full_work, Random& random) {
  const auto every = [&](std::uint64_t frames) { return i / frames % 2 == 0 ? Budget::work(0) : Budget::unlimited(); };
  switch (way) {
    case Way::RandomLevels:
      watch.input.max_level = static_cast<Level>(random.bits() % 4);
      break;
    case Way::RandomPairs:
      watch.input.budget = Budget::work(random.bits() % (full_work + 1));
      break;
    case Way::Every10:
      watch.input.budget = every(10);
      break;
    case Way::Every60:
      watch.input.budget = every(60);
      break;
    default:
      break;
  }
}

// One heap: the shipped one, or that of the seed so many further on. `at` is told the completed share.
Result<Found> run_heap(const Context& context, const Pile& pile, Way way, std::uint64_t heap,
                       const std::function<Status(double)>& at) {
  Result<SceneWatch> started = SceneWatch::start(
      context, pile.file,
      [&](Scene& scene) {
        for (SceneMaterial& material : scene.materials) material.material.friction = pile.friction;
        if (way == Way::RandomPairs) scene.policy.kind = scheduler::PolicyKind::Random;
      },
      pile.bodies, heap);
  if (!started) return started.error();
  SceneWatch& watch = started.value();
  if (way == Way::RootsOnly) watch.input.max_level = 0;
  watch.input.measure_energy = true;
  const std::uint64_t settle = watch.frames_of(kSettleS);
  const std::uint64_t frames = settle + watch.frames_of(kWatchS);
  Random random(51);
  Found found;
  double least_j = HUGE_VAL;
  std::uint64_t full_work = 0;
  for (std::uint64_t i = 0; i < frames; ++i) {
    if (i >= settle) set_levels(watch, way, i - settle, full_work, random);
    const FrameReport report = watch.step();
    if (i < settle) {
      full_work = report.work_refine;
      continue;
    }
    const double energy_j = report.kinetic_j + report.potential_j;
    least_j = std::min(least_j, energy_j);
    found.excess = std::isfinite(energy_j) ? std::max(found.excess, energy_j - least_j) : HUGE_VAL;
    if (i % 4 == 0) found.largest_mps = std::max(found.largest_mps, watch.largest_speed_mps());
    const Status go_on = at(static_cast<double>(i) / static_cast<double>(frames));
    if (!go_on) return go_on.error();
  }
  found.excess /= watch.weight_scale_j();
  found.height_m = watch.mean_height_m();
  found.outside = watch.outside();
  return found;
}

// All heaps, side by side on the threads of the study; each is stepped by one, so figures do not depend on their
// number. `first` and `share`: where in the progress of the case this is.
Result<std::vector<Found>> run_heaps(const Context& context, const Pile& pile, Way way, double first, double share) {
  Context alone = context;
  alone.executor = ExecutorKind::Serial;
  alone.threads = 1;
  std::vector<std::optional<Result<Found>>> found(context.heaps);
  std::atomic<std::uint64_t> next = 0;
  const auto work = [&](bool tells) {
    for (std::uint64_t heap = next++; heap < context.heaps; heap = next++) {
      const double begun = first + share * static_cast<double>(heap) / static_cast<double>(context.heaps);
      found[heap] = run_heap(alone, pile, way, heap, [&](double done) -> Status {
        if (tells) return context.at(begun + share * done / static_cast<double>(context.heaps));
        if (context.stop.stop_requested()) return Error{ErrorKind::Cancelled, "stopped; nothing was written"};
        return Done{};
      });
    }
  };
  {
    const int threads = context.threads > 0 ? context.threads : static_cast<int>(std::thread::hardware_concurrency());
    std::vector<std::jthread> others;
    for (int thread = 1; thread < threads; ++thread) others.emplace_back(work, false);
    work(true);
  }
  std::vector<Found> all;
  for (const std::optional<Result<Found>>& one : found) {
    if (!*one) return one->error();
    all.push_back(one->value());
  }
  return all;
}

// Of an even number the lower one of the two in the middle.
double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void add_both(Context& context, const std::string& figure, const char* unit, const std::vector<double>& values,
              double median_at_most, double each_at_most, const std::string& with) {
  context.add(figure + ", median" + with, unit, median_of(values), median_at_most);
  context.add(figure + ", largest" + with, unit, *std::max_element(values.begin(), values.end()), each_at_most);
}

Status change_levels(Context& context, const Pile& pile) {
  std::vector<Found> full;
  constexpr Way kWays[] = {Way::Full, Way::RandomLevels, Way::RandomPairs, Way::Every10, Way::Every60, Way::RootsOnly};
  double done = 0;
  for (const Way way : kWays) {
    const Result<std::vector<Found>> run = run_heaps(context, pile, way, done / 6, 1.0 / 6);
    if (!run) return run.error();
    ++done;
    const std::vector<Found>& found = run.value();
    if (way == Way::Full) full = found;
    const std::string with = fmt::format(", {}", name_of(way));
    std::vector<double> excesses, speeds, differences;
    std::size_t outside = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      excesses.push_back(found[i].excess);
      speeds.push_back(found[i].largest_mps);
      differences.push_back(std::abs(found[i].height_m / full[i].height_m - 1));
      outside += found[i].outside;
    }
    const Heaps& bounds = bounds_of(pile, way);
    add_both(context, "energy over its running minimum, a body in m g R", "1", excesses, bounds.median.excess,
             bounds.each.excess, with);
    context.add("bodies out of the tray" + with, "", static_cast<double>(outside), 0);
    add_both(context, "largest speed", "m/s", speeds, bounds.median.speed_mps, bounds.each.speed_mps, with);
    if (way == Way::Full) {
      context.add("mean height" + with, "m", full.front().height_m, {});
      continue;
    }
    add_both(context, "difference of the mean height", "1", differences, bounds.median.height, bounds.each.height,
             with);
  }
  return Done{};
}

}  // namespace

Status jacks_change_levels(Context& context) {
  return change_levels(context, {"jacks.json",
                                 300,
                                 0,
                                 {{6e-3, 1, 0.1}, {8e-3, 2.4, 0.1}},
                                 {{0.01, 3.4, 0.3}, {0.08, 4.2, 0.49}},
                                 {{1e-3, 0.2, 0.25}, {1e-3, 1.1, 0.25}}});
}
Status jacks_change_levels_with_friction(Context& context) {
  const Bounds roots = {1e-3, 0.2, 0.25};
  return change_levels(
      context, {"jacks.json", 300, 0.5, {{}, {1e-3, 1.5, 0.1}}, {{}, {1e-3, 4.5, 0.36}}, {roots, {1e-3, 0.27, 0.25}}});
}
Status meshes_change_levels(Context& context) {
  return change_levels(context, {"pile.json",
                                 100,
                                 0,
                                 {{1e-3, 0.6, 0.1}, {1.7e-3, 1.6, 0.1}},
                                 {{0.13, 2.6, 0.1}, {0.2, 3.5, 0.12}},
                                 {{4.5e-3, 1.3, 0.25}, {0.013, 1.35, 0.25}}});
}
Status meshes_change_levels_with_friction(Context& context) {
  return change_levels(
      context,
      {"pile.json", 100, 0.5, {{}, {3e-3, 1.5, 0.1}}, {{}, {0.013, 3, 0.1}}, {{1e-3, 0.2, 0.25}, {1e-3, 0.3, 0.28}}});
}

}  // namespace poise::accuracy
