// SPDX-License-Identifier: MIT
// Traversal of two sphere trees of meshes from the roots to level 3, near first contact: nanoseconds a query and an
// expansion; then the polygons in the leaves that overlap, compared with the same query in libfcl. Before anything is
// timed, random poses near first contact are checked against the triangles themselves (libfcl). It is an error if a
// level finds nothing where surfaces meet, or if the polygons give another result.
//
//   bench_tree_query [--mesh FILE]... [--trees FOLDER] [--poses N] [--margin SHARE] [options of Google Benchmark]
//
// --margin: polygons are timed with a margin of this share of the smaller body's radius, as in a frame, instead of 0.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collision/front/pair_refinement.h"
#include "collision/near_touch.h"
#include "collision/triangles/polygon_contact.h"
#include "latencies.h"
#include "poise/assets/mesh_file.h"
#include "poise/assets/sph_file.h"

namespace poise::collision {
namespace {

namespace fs = std::filesystem;

constexpr Level kDepth = 3;
constexpr std::size_t kTimedPoses = 10000;  // too many for a branch predictor to memorise (it memorises 300, measured)

struct Settings {
  std::vector<fs::path> meshes;
  fs::path trees;            ///< folder of cached trees, NAME.sph; empty: every tree is built
  std::size_t poses = 2000;  ///< measured, for each pair of meshes
  double margin = 0;         ///< of polygons that are timed, as a share of the smaller bounding radius
};

struct NamedShape {
  std::string name;
  OracleShape tested;
};

struct Reports {
  std::size_t touching = 0;
  std::size_t lost = 0;          ///< surfaces meet and a level found nothing
  std::size_t false_alarms = 0;  ///< surfaces do not meet and level 3 found something
  std::size_t expansions = 0;
  std::size_t hits = 0;
  std::size_t mismatches = 0;  ///< polygons and oracle differ, beyond the tolerance
};

struct Case {
  std::string name;
  const Shape* a = nullptr;
  const Shape* b = nullptr;
  const NamedShape* shape_a = nullptr;
  const NamedShape* shape_b = nullptr;
  std::vector<PosedPair> poses;
  Reports reports;
  std::size_t tested = 0;
  double margin_m = 0;
};

PairFrame frame_of(const Case& c, const PosedPair& posed, double margin_m = 0) {
  return make_pair_frame(*c.a, posed.a, *c.b, posed.b, margin_m, 0);
}

/// Result of one query.
struct Walk {
  std::array<std::uint32_t, kDepth + 1> front{1};  ///< entries at each level
  std::uint32_t expansions = 0;
  bool full = false;
};

using Scratch = std::array<std::vector<FrontEntry>, 2>;

/// Computes the fronts alone, level by level, until one is empty.
Walk walk(const PairFrame& frame, Scratch& scratch) {
  Walk walk;
  scratch[0][0] = {0, 0};
  for (std::size_t level = 1; level <= kDepth && walk.front[level - 1] > 0; ++level) {
    const std::uint32_t count = walk.front[level - 1];
    const Expansion made = expand(frame, std::span(scratch[(level + 1) % 2]).first(count), scratch[level % 2]);
    walk.full |= made.consumed < count;
    walk.expansions += made.consumed;
    walk.front[level] = made.hits;
  }
  return walk;
}

/// Refines as a step does: in quanta, with the contact of every level published.
std::uint32_t refine(const PairFrame& frame, std::span<FrontPool> pools, SinglePair& pair) {
  std::uint32_t expansions = 0;
  pair.deepest = deepest_level(*frame.a, *frame.b, kDepth);
  while (pair.refinable()) {
    expansions += pair.front_entries;
    LevelProgress progress = begin_level(pair, pools[0]);
    while (run_quantum(frame, pools, 0, 512, progress) == Quantum::More) {
    }
    publish_level(frame, Mat3::Identity(), progress, pair, pair);
    if (pair.points_due && !pair.refinable()) make_points(frame, pools, pair, pair);
  }
  return expansions;
}

void count(benchmark::State& state, const Case& c) {
  const auto share = [](std::size_t part, std::size_t whole) {
    return static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(whole, 1));
  };
  const Reports& v = c.reports;
  state.counters["tested"] = static_cast<double>(c.tested);
  state.counters["touching"] = static_cast<double>(v.touching);
  state.counters["false_alarms"] = share(v.false_alarms, c.tested - v.touching);
  state.counters["expansions"] = share(v.expansions, c.tested);
  state.counters["hits_per_expansion"] = share(v.hits, v.expansions);
}

template <class Query>
void time_queries(benchmark::State& state, const Case& c, Query&& query) {
  if (c.reports.lost > 0) {
    state.SkipWithError(fmt::format("{} contacts were lost", c.reports.lost).c_str());
    return;
  }
  const std::size_t timed = std::min(c.poses.size(), kTimedPoses);
  bench::Latencies latencies;
  std::vector<double> per_expansion_ns;
  std::size_t next = 0;
  for (auto _ : state) {
    const PosedPair& posed = c.poses[next];
    next = next + 1 == timed ? 0 : next + 1;
    std::uint32_t expansions = 0;
    const double seconds = latencies.time(state, [&] { expansions = query(posed); });
    per_expansion_ns.push_back(1e9 * seconds / expansions);
  }
  latencies.report(state);
  std::ranges::nth_element(per_expansion_ns,
                           per_expansion_ns.begin() + static_cast<std::ptrdiff_t>(per_expansion_ns.size() / 2));
  state.counters["p50_ns_per_expansion"] = per_expansion_ns[per_expansion_ns.size() / 2];
  count(state, c);
}

void time_fronts(benchmark::State& state, const Case& c) {
  Scratch scratch{std::vector<FrontEntry>(1U << 16U), std::vector<FrontEntry>(1U << 16U)};
  time_queries(state, c, [&](const PosedPair& posed) {
    const Walk walked = walk(frame_of(c, posed), scratch);
    benchmark::DoNotOptimize(walked.front[kDepth]);
    return walked.expansions;
  });
}

void time_contacts(benchmark::State& state, const Case& c) {
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 17U);
  time_queries(state, c, [&](const PosedPair& posed) {
    SinglePair pair;
    pools[0].clear();
    const std::uint32_t expansions = refine(frame_of(c, posed), pools, pair);
    benchmark::DoNotOptimize(pair.contact.estimated_separation_m);
    return expansions;
  });
}

/// Refines the polygons of a pair whose trees are done, and returns the result of the pair.
std::uint32_t polygons(const PairFrame& frame, std::span<const FrontPool> pools, SinglePair& pair) {
  PolygonProgress progress;
  begin_polygons(frame, Mat3::Identity(), pair, pair, progress);
  while (run_polygons(frame, pools, 512, progress) == Quantum::More) {
  }
  publish_polygons(progress, pair, pair);
  return pair.front_entries;
}

double median_us(std::vector<double>& seconds) {
  if (seconds.empty()) return 0;
  const auto middle = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
  std::nth_element(seconds.begin(), middle, seconds.end());
  return 1e6 * *middle;
}

/// Times the polygons alone, after the trees; poses that a tree separates are skipped.
void time_polygons(benchmark::State& state, const Case& c) {
  if (c.reports.mismatches > 0) {
    state.SkipWithError(fmt::format("polygons and the oracle disagree about {} poses", c.reports.mismatches).c_str());
    return;
  }
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 17U);
  const std::size_t timed = std::min(c.poses.size(), kTimedPoses);
  bench::Latencies latencies;
  std::size_t next = 0;
  double seconds = 0;
  double leaf_pairs = 0;
  double units = 0;
  std::vector<double> apart;
  std::vector<double> crossing;
  for (auto _ : state) {
    SinglePair pair;
    PairFrame frame;
    do {
      frame = frame_of(c, c.poses[next], c.margin_m);
      next = next + 1 == timed ? 0 : next + 1;
      pair = {};
      pools[0].clear();
      refine(frame, pools, pair);
    } while (pair.apart);
    pair.polygons = true;
    ++pair.deepest;
    units += polygon_units(*c.a, *c.b, pools, pair.front);
    const double there = latencies.time(state, [&] { leaf_pairs += polygons(frame, pools, pair); });
    seconds += there;
    const bool overlaps = pair.contact.present && pair.contact.estimated_separation_m <= 0;
    (overlaps ? crossing : apart).push_back(there);
  }
  latencies.report(state);
  const auto pairs = static_cast<double>(state.iterations());
  state.counters["leaf_pairs"] = leaf_pairs / pairs;
  state.counters["ns_per_leaf_pair"] = 1e9 * seconds / leaf_pairs;
  state.counters["ns_per_unit"] = 1e9 * seconds / units;
  state.counters["p50_apart_us"] = median_us(apart);
  state.counters["p50_crossing_us"] = median_us(crossing);
}

/// Times the same query in the oracle.
void time_oracle(benchmark::State& state, const NamedShape& a, const NamedShape& b, const Case& c) {
  const std::size_t timed = std::min(c.poses.size(), kTimedPoses);
  bench::Latencies latencies;
  std::size_t next = 0;
  for (auto _ : state) {
    const PosedPair& posed = c.poses[next];
    next = next + 1 == timed ? 0 : next + 1;
    bool touches = false;
    latencies.time(state, [&] { touches = a.tested.oracle.touches(posed.a, b.tested.oracle, posed.b); });
    benchmark::DoNotOptimize(touches);
  }
  latencies.report(state);
}

Result<NamedShape> load(const fs::path& file, const fs::path& trees) {
  Result<TriangleMesh> mesh = read_mesh(file, {});
  if (!mesh) return mesh.error();
  center_mesh(mesh.value());
  const fs::path kept = trees / (file.stem().string() + ".sph");
  const bool keeps = !trees.empty();
  const bool there = keeps && fs::exists(kept);
  Result<SphereTree> tree = there ? read_sph(kept) : build_sphere_tree(mesh.value(), {.depth = kDepth});
  if (!tree) return tree.error();
  if (keeps && !there) {
    if (const Status written = write_sph(tree.value(), kept); !written) return written.error();
  }
  return NamedShape{file.stem().string(), make_oracle_shape(mesh.value(), std::move(tree.value()))};
}

Case oracle(const NamedShape& a, const NamedShape& b, std::size_t poses) {
  constexpr double kBand = 8e-3;
  Case c{a.name + "/" + b.name, &a.tested.shape, &b.tested.shape, &a, &b, {}, {}, poses};
  std::mt19937_64 random(17);
  Scratch scratch{std::vector<FrontEntry>(1U << 18U), std::vector<FrontEntry>(1U << 18U)};
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 18U);
  for (std::size_t i = 0; i < poses; ++i) {
    const PosedPair posed = pose_near_first_touch(a.tested, b.tested, kBand, random);
    const bool touches = a.tested.oracle.touches(posed.a, b.tested.oracle, posed.b);
    const Walk walked = walk(frame_of(c, posed), scratch);
    if (touches) ++c.reports.touching;
    pools[0].clear();
    SinglePair pair;
    const PairFrame frame = frame_of(c, posed);
    refine(frame, pools, pair);
    if (!pair.apart) {
      pair.polygons = true;
      ++pair.deepest;
      polygons(frame, pools, pair);
    }
    const bool hair = pair.contact.present && std::abs(pair.contact.estimated_separation_m) <
                                                  1e-4 * std::min(a.tested.diagonal_m, b.tested.diagonal_m);
    if (touches != (pair.contact.present && pair.contact.estimated_separation_m <= 0) && !hair) ++c.reports.mismatches;
    if (touches && (walked.front[kDepth] == 0 || walked.full)) ++c.reports.lost;
    if (!touches && walked.front[kDepth] > 0) ++c.reports.false_alarms;
    c.reports.expansions += walked.expansions;
    for (std::size_t level = 1; level <= kDepth; ++level) c.reports.hits += walked.front[level];
    if (c.poses.size() < kTimedPoses) c.poses.push_back(posed);
  }
  return c;
}

/// Removes our options from the arguments. Returns what is wrong with them, or empty.
std::string take_options(int& argc, char** argv, Settings& settings) {
  int kept = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string_view name = argv[i];
    if (name != "--mesh" && name != "--trees" && name != "--poses" && name != "--margin") {
      argv[kept++] = argv[i];
      continue;
    }
    if (++i == argc) return fmt::format("{} needs a value", name);
    const std::string_view value = argv[i];
    if (name == "--mesh") settings.meshes.emplace_back(value);
    if (name == "--trees") settings.trees = value;
    if (name == "--margin") {
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), settings.margin);
      if (error != std::errc() || end != value.data() + value.size() ||
          !(settings.margin >= 0 && settings.margin <= 1)) {
        return fmt::format("--margin {} must be a number from 0 to 1", value);
      }
    }
    if (name == "--poses") {
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), settings.poses);
      if (error != std::errc() || end != value.data() + value.size() || settings.poses == 0) {
        return fmt::format("--poses {} must be a number > 0", value);
      }
    }
  }
  argc = kept;
  return {};
}

std::vector<fs::path> default_meshes() {
  std::vector<fs::path> meshes{fs::path(POISE_SOURCE_DIR) / "scenes/meshes/jack.obj"};
  const fs::path ur10 = "/usr/share/doc/simbody/examples/src/TaskSpaceControl-UR10/geometry";
  for (const char* name : {"Forearm.obj", "Wrist1.obj"}) {
    if (fs::exists(ur10 / name)) meshes.push_back(ur10 / name);
  }
  return meshes;
}

int run(int argc, char** argv) {
  Settings settings;
  std::string wrong = take_options(argc, argv, settings);
  if (!wrong.empty()) {
    fmt::print(stderr, "bench_tree_query: {}\n", wrong);
    return 2;
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  if (settings.meshes.empty()) settings.meshes = default_meshes();
  std::vector<NamedShape> shapes;
  for (const fs::path& file : settings.meshes) {
    Result<NamedShape> shape = load(file, settings.trees);
    if (!shape) {
      fmt::print(stderr, "bench_tree_query: {}\n", shape.error().message);
      return 1;
    }
    shapes.push_back(std::move(shape.value()));
  }
  std::vector<Case> cases;
  cases.reserve(shapes.size() * shapes.size());
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = i; j < shapes.size(); ++j) cases.push_back(oracle(shapes[i], shapes[j], settings.poses));
  }
  for (Case& c : cases) c.margin_m = settings.margin * std::min(c.a->bounding_radius_m, c.b->bounding_radius_m);
  bool lost = false;
  for (const Case& c : cases) {
    lost |= c.reports.lost > 0 || c.reports.mismatches > 0;
    benchmark::RegisterBenchmark(("fronts/" + c.name).c_str(), time_fronts, c)->UseManualTime();
    benchmark::RegisterBenchmark(("contacts/" + c.name).c_str(), time_contacts, c)->UseManualTime();
    benchmark::RegisterBenchmark(("polygons/" + c.name).c_str(), time_polygons, c)->UseManualTime();
    benchmark::RegisterBenchmark(("oracle/" + c.name).c_str(), time_oracle, *c.shape_a, *c.shape_b, c)->UseManualTime();
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return lost ? 1 : 0;
}

}  // namespace
}  // namespace poise::collision

int main(int argc, char** argv) { return poise::collision::run(argc, argv); }
