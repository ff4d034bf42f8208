// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "collision/instruction_sets.h"
#include "geometry/shared_tree.h"
#include "poise/scene/scene.h"

/// The state of every shipped scene after 200 frames (or as many as it says) with the work clock, to the bit. A changed
/// hash means changed motion, and the commit that changes it must give the reason. Run with --gtest_filter=StateHash.*
/// after a deliberate change; each failure prints the new value.
namespace poise {
namespace {

constexpr std::uint64_t kFrames = 200;

struct Golden {
  const char* scene;  // a file under scenes/
  ContactModel contact = ContactModel::Fitted;
  std::uint64_t bodies = 0;      // number made by all generators; 0: the scene's own number
  std::uint64_t work_units = 0;  // of refinement a frame; 0: unlimited
  const char* with = "";         // sleeping, polygons or backtracking, in addition to the scene's settings
  std::uint64_t hash = 0;
  std::uint64_t frames = kFrames;
};

const char* name_of(ContactModel contact) {
  constexpr std::array<const char*, 3> kNames{"Paper", "Wrench", "Fitted"};
  return kNames[static_cast<std::size_t>(contact)];
}

void PrintTo(const Golden& golden, std::ostream* out) { *out << golden.scene << ' ' << name_of(golden.contact); }

std::uint64_t hash_after(const Golden& golden, int threads) {
  const std::filesystem::path file = std::filesystem::path(POISE_SOURCE_DIR) / "scenes" / golden.scene;
  const Result<Scene> scene = read_scene(file);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().message);
  const std::string with = golden.with;
  SceneRunOptions options;
  options.world.contact = golden.contact;
  options.world.threads = threads;
  options.world.executor = ExecutorKind::Threads;
  options.world.sleeping = with == "sleeping";
  options.world.policy = scene.value().policy;
  options.tree_cache = test::shared_trees();
  if (golden.bodies > 0) options.bodies = golden.bodies;
  Result<SceneRun> run = SceneRun::create(scene.value(), options);
  EXPECT_TRUE(run.ok()) << (run.ok() ? "" : run.error().message);
  StepInput input;
  input.dt_s = scene.value().dt_s;
  input.budget = golden.work_units > 0 ? Budget::work(golden.work_units) : Budget::unlimited();
  input.max_level = scene.value().max_level;
  input.polygons = scene.value().polygons || with == "polygons";
  input.backtracking = scene.value().backtracking || with == "backtracking";
  for (std::uint64_t frame = 0; frame < golden.frames; ++frame) {
    EXPECT_TRUE(run.value().before_frame(frame).ok());
    input.view = run.value().view();
    run.value().world().step(input);
  }
  return run.value().world().state_hash();
}

class StateHash : public testing::TestWithParam<Golden> {};

TEST_P(StateHash, StaysAsItWasOnOneThreadAndOnTwo) {
  const Golden& golden = GetParam();
  for (const int threads : {1, 2}) {
    const std::uint64_t hash = hash_after(golden, threads);
    EXPECT_EQ(hash, golden.hash) << fmt::format("{} {}{}{} on {} threads: 0x{:016x}", golden.scene,
                                                name_of(golden.contact), *golden.with == '\0' ? "" : " ", golden.with,
                                                threads, hash);
  }
}

class StateHashOfKernels : public StateHash {};

TEST_P(StateHashOfKernels, IsTheSameOnEveryInstructionSet) {
  const Golden& golden = GetParam();
  std::vector<std::string> sets;
  collision::on_every_instruction_set([&](const char* name) {
    EXPECT_EQ(hash_after(golden, 1), golden.hash) << name;
    sets.emplace_back(name);
  });
  // All that the library was compiled for and this machine has; the kernels without vector instructions, which
  // Highway calls by either name according to the compiler, are compiled for any.
  EXPECT_GE(sets.size(), 2U);
  EXPECT_EQ(std::count(sets.begin(), sets.end(), "SCALAR") + std::count(sets.begin(), sets.end(), "EMU128"), 1)
      << fmt::format("{}", fmt::join(sets, ", "));
  EXPECT_EQ(std::count(sets.begin(), sets.end(), "SSSE3"), 0) << "no kernels were compiled for it";
}

using enum ContactModel;

const std::vector<Golden> kGoldens = {
#include "golden/state_hashes.inc"
};

// Those that use every kernel (Wrench has one of its own) and do not take long.
std::vector<Golden> of_kernels() {
  constexpr std::array<std::string_view, 4> kScenes{"pile.json", "gas.json", "bullets.json", "real-meshes.json"};
  std::vector<Golden> chosen;
  for (const Golden& golden : kGoldens) {
    if (golden.contact != Paper && std::find(kScenes.begin(), kScenes.end(), golden.scene) != kScenes.end())
      chosen.push_back(golden);
  }
  return chosen;
}

std::string test_name(const testing::TestParamInfo<Golden>& info) {
  std::string name = std::filesystem::path(info.param.scene).stem().string() + "_" + name_of(info.param.contact);
  if (*info.param.with != '\0') name += std::string("_") + info.param.with;
  if (info.param.frames != kFrames) name += fmt::format("_{}", info.param.frames);
  std::erase(name, '-');
  return name;
}

INSTANTIATE_TEST_SUITE_P(OfScenes, StateHash, testing::ValuesIn(kGoldens), test_name);
INSTANTIATE_TEST_SUITE_P(OfScenes, StateHashOfKernels, testing::ValuesIn(of_kernels()), test_name);

}  // namespace
}  // namespace poise
