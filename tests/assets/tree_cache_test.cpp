// SPDX-License-Identifier: MIT
#include "poise/assets/tree_cache.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>

#include "assets/cache/tree_cache_entry.h"
#include "assets/cache/tree_cache_folder.h"
#include "meshes.h"
#include "parallel/executor.h"
#include "scene/temporary_folder.h"

namespace poise {
namespace {

namespace fs = std::filesystem;
using geometry::entry_bytes;
using geometry::entry_tree;
using geometry::tree_key;
using testing::contents;
using testing::TemporaryFolder;

/// A small tree that needs no building: nine spheres, three levels with a leaf above the deepest.
SphereTree small_tree() {
  std::vector<Sphere> spheres;
  for (int i = 0; i < 9; ++i) spheres.push_back({Vec3(i, 0.25 * i, 0), 0.25});
  SphereTree tree = tree_of_spheres(spheres).value();
  for (std::size_t i = 0; i < tree.node_count(); ++i) {
    tree.protrusion_max_m[i] = 0.5F * static_cast<float>(i);
    tree.protrusion_mean_m[i] = 0.25F * static_cast<float>(i);
    tree.fit[i] = {1, -2, 3, 0.5F * static_cast<float>(i), 0.25F, -0.125F};
  }
  return tree;
}

bool same_bits(const SphereTree& a, const SphereTree& b) {
  return test::same_tree(a, b) && a.fit.size() == b.fit.size() &&
         std::memcmp(a.fit.data(), b.fit.data(), a.fit.size() * sizeof(NodeFit)) == 0;
}

void put(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

const geometry::TreeKey kKey = tree_key(test::box_mesh(Vec3(1, 2, 3)), {});

TEST(TreeCacheEntry, GivesBackTheTreeBitForBit) {
  const SphereTree tree = small_tree();
  const auto read = entry_tree(entry_bytes(tree, kKey), kKey);
  ASSERT_TRUE(read);
  EXPECT_TRUE(same_bits(*read, tree));
}

TEST(TreeCacheEntry, IsRefusedWhenAnyOneByteIsChanged) {
  const std::string bytes = entry_bytes(small_tree(), kKey);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int mask : {0x01, 0x80, 0xff}) {
      std::string changed = bytes;
      changed[i] = static_cast<char>(changed[i] ^ mask);
      EXPECT_FALSE(entry_tree(changed, kKey)) << "byte " << i;
    }
  }
}

TEST(TreeCacheEntry, IsRefusedWhenItIsCutOrLongerAnywhere) {
  const std::string bytes = entry_bytes(small_tree(), kKey);
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_FALSE(entry_tree(bytes.substr(0, length), kKey)) << length;
  EXPECT_FALSE(entry_tree(bytes + '\0', kKey));
  EXPECT_FALSE(entry_tree(bytes + bytes, kKey));
}

TEST(TreeCacheEntry, IsRefusedUnderAnotherKey) {
  TreeBuildOptions other;
  other.seed = 2;
  EXPECT_FALSE(entry_tree(entry_bytes(small_tree(), kKey), tree_key(test::box_mesh(Vec3(1, 2, 3)), other)));
}

// Each has a matching checksum, which does not prove that the content is valid.
TEST(TreeCacheEntry, IsRefusedWhenAnIndexOrCountIsWrongThoughItsChecksumIsRight) {
  const SphereTree sound = small_tree();
  for (std::size_t i = 0; i < sound.node_count(); ++i) {
    for (const std::uint32_t change : {1U, 0xffffffffU, 0x80000000U}) {
      SphereTree tree = sound;
      tree.first_child[i] += change;
      EXPECT_FALSE(entry_tree(entry_bytes(tree, kKey), kKey)) << "first_child " << i;
    }
    for (const std::uint8_t count : std::initializer_list<std::uint8_t>{0, 1, 2, 8, 9, 255}) {
      SphereTree tree = sound;
      if (tree.child_count[i] == count) continue;
      tree.child_count[i] = count;
      EXPECT_FALSE(entry_tree(entry_bytes(tree, kKey), kKey)) << "child_count " << i << " = " << int{count};
    }
  }
  // The last entry is the number of nodes, which the head contains too, so only the others can be wrong unnoticed.
  for (std::size_t i = 0; i + 1 < sound.level_begin.size(); ++i) {
    for (const std::uint32_t change : {1U, 0xffffffffU}) {
      SphereTree tree = sound;
      tree.level_begin[i] += change;
      EXPECT_FALSE(entry_tree(entry_bytes(tree, kKey), kKey)) << "level_begin " << i;
    }
  }
}

TEST(TreeCacheEntry, IsRefusedWhenANumberIsOutOfRangeThoughItsChecksumIsRight) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  for (std::vector<float> SphereTree::*array :
       {&SphereTree::x_m, &SphereTree::y_m, &SphereTree::z_m, &SphereTree::radius_m, &SphereTree::protrusion_max_m,
        &SphereTree::protrusion_mean_m}) {
    for (const float value : {kNan, kInfinite, 1e20F}) {
      SphereTree tree = small_tree();
      (tree.*array)[3] = value;
      EXPECT_FALSE(entry_tree(entry_bytes(tree, kKey), kKey)) << value;
    }
  }
  for (std::vector<float> SphereTree::*array :
       {&SphereTree::radius_m, &SphereTree::protrusion_max_m, &SphereTree::protrusion_mean_m}) {
    SphereTree tree = small_tree();
    (tree.*array)[3] = -1;
    EXPECT_FALSE(entry_tree(entry_bytes(tree, kKey), kKey));
  }
  for (const float variance : {kNan, kInfinite, -1.0F}) {
    SphereTree tree = small_tree();
    tree.fit[2].variance_m2 = variance;
    EXPECT_FALSE(entry_tree(entry_bytes(tree, kKey), kKey)) << variance;
  }
}

TEST(TreeCacheKey, IsAnotherForEachThingThatDecidesTheTreeAndTheSameForTheRest) {
  const TriangleMesh box = test::box_mesh(Vec3(1, 2, 3));
  EXPECT_EQ(tree_key(box, {}), kKey);
  TreeBuildOptions same;
  same.threads = 7;
  same.progress = [](double) {};
  EXPECT_EQ(tree_key(box, same), kKey);
  std::vector<TreeBuildOptions> others(4);
  others[0].depth = 2;
  others[1].preset = TreePreset::Best;
  others[2].solidity = Solidity::Shell;
  others[3].seed = 2;
  for (const TreeBuildOptions& other : others) EXPECT_NE(tree_key(box, other), kKey);
  TriangleMesh moved = box;
  moved.vertices_m[7].z() = std::nextafter(moved.vertices_m[7].z(), 9.0);
  EXPECT_NE(tree_key(moved, {}), kKey);
  TriangleMesh turned = box;
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_NE(tree_key(turned, {}), kKey);
}

/// Mesh and options of a tree that is built quickly, and the tree.
class TreeCache : public ::testing::Test {
 protected:
  Result<SphereTree> ask() { return cached_sphere_tree(mesh_, options_, settings_, &outcome_, &evicted_); }
  fs::path entry() const { return settings_.folder / (geometry::key_text(tree_key(mesh_, options_)) + ".poisetree"); }

  TemporaryFolder folder_;
  TriangleMesh mesh_ = test::box_mesh(Vec3(1, 2, 3));
  TreeBuildOptions options_{.depth = 1, .preset = TreePreset::Fast, .threads = 1};
  TreeCacheSettings settings_{.folder = folder_.path() / "not" / "there" / "yet"};
  SphereTree built_ = build_sphere_tree(mesh_, options_).value();
  TreeCacheOutcome outcome_{};
  std::size_t evicted_ = 99;
};

TEST_F(TreeCache, BuildsOnceAndGivesTheSameBitsAfterwards) {
  EXPECT_TRUE(same_bits(ask().value(), built_));
  EXPECT_EQ(outcome_, TreeCacheOutcome::Built);
  EXPECT_EQ(evicted_, 0U);
  double told = 0;
  options_.progress = [&told](double share) { told = share; };
  EXPECT_TRUE(same_bits(ask().value(), built_));
  EXPECT_EQ(outcome_, TreeCacheOutcome::Hit);
  EXPECT_EQ(told, 1);
  struct stat status {};
  ASSERT_EQ(::stat(settings_.folder.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0700U);
  EXPECT_EQ(std::distance(fs::directory_iterator(settings_.folder), fs::directory_iterator()), 1);
}

TEST_F(TreeCache, ReplacesWhatIsNoSoundEntryAndUsesTheNewOneThen) {
  ASSERT_TRUE(ask());
  const std::string sound = contents(entry());
  std::string flipped = sound;
  flipped[sound.size() / 2] = static_cast<char>(flipped[sound.size() / 2] ^ 1);
  std::string old_version = sound;
  old_version[16] = static_cast<char>(old_version[16] ^ 1);
  const std::string other_key = entry_bytes(built_, kKey);
  const std::string huge(geometry::kMostEntryBytes + 1, 'x');
  for (const std::string& bad :
       {flipped, old_version, other_key, huge, std::string(), sound.substr(0, 40), std::string("foreign")}) {
    put(entry(), bad);
    EXPECT_TRUE(same_bits(ask().value(), built_));
    EXPECT_EQ(outcome_, TreeCacheOutcome::Rebuilt) << bad.size();
    EXPECT_EQ(contents(entry()), sound);
  }
  EXPECT_TRUE(same_bits(ask().value(), built_));
  EXPECT_EQ(outcome_, TreeCacheOutcome::Hit);
}

TEST_F(TreeCache, NeitherWaitsForAPipeNorWritesThroughALink) {
  ASSERT_TRUE(ask());
  fs::remove(entry());
  ASSERT_EQ(::mkfifo(entry().c_str(), 0600), 0);
  EXPECT_TRUE(same_bits(ask().value(), built_));
  EXPECT_EQ(outcome_, TreeCacheOutcome::Rebuilt);
  fs::remove(entry());
  put(folder_.path() / "mine.txt", "precious");
  fs::create_symlink(folder_.path() / "mine.txt", entry());
  EXPECT_TRUE(same_bits(ask().value(), built_));
  EXPECT_EQ(outcome_, TreeCacheOutcome::Rebuilt);
  EXPECT_EQ(contents(folder_.path() / "mine.txt"), "precious");
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(entry())));
}

TEST_F(TreeCache, GoesOnWithoutAFolderThatCanBeWritten) {
  put(folder_.path() / "file", "");
  for (const fs::path& folder : {folder_.path() / "file", folder_.path() / "file" / "below", fs::path("/proc/poise")}) {
    settings_.folder = folder;
    EXPECT_TRUE(same_bits(ask().value(), built_));
    EXPECT_EQ(outcome_, TreeCacheOutcome::NotWritable) << folder;
  }
  settings_.folder = folder_.path();
  fs::create_directories(entry() / "inside");
  EXPECT_TRUE(same_bits(ask().value(), built_));
  EXPECT_EQ(outcome_, TreeCacheOutcome::NotWritable);
}

TEST_F(TreeCache, TouchesNothingWhenItIsOff) {
  settings_.on = false;
  EXPECT_TRUE(same_bits(ask().value(), built_));
  EXPECT_EQ(outcome_, TreeCacheOutcome::Off);
  EXPECT_EQ(folder_.entries(), 0U);
}

TEST_F(TreeCache, RefusesWhatTheBuilderRefusesAndKeepsNothing) {
  options_.depth = kMaxTreeDepth + 1;
  const auto refused = ask();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, build_sphere_tree(mesh_, options_).error().message);
  EXPECT_EQ(folder_.entries(), 0U);
}

TEST_F(TreeCache, IsSharedByThreadsThatComeAtOnce) {
  const auto executor = parallel::make_executor(ExecutorKind::Threads, 2);
  std::vector<SphereTree> trees(6);
  parallel::parallel_for(*executor, trees.size(), 1, [&](std::size_t i, std::size_t, int) {
    trees[i] = cached_sphere_tree(mesh_, options_, settings_).value();
  });
  for (const SphereTree& tree : trees) EXPECT_TRUE(same_bits(tree, built_));
  EXPECT_EQ(std::distance(fs::directory_iterator(settings_.folder), fs::directory_iterator()), 1)
      << "nothing but the entry is left";
  EXPECT_TRUE(same_bits(ask().value(), built_));
  EXPECT_EQ(outcome_, TreeCacheOutcome::Hit);
}

class TreeCacheLimit : public TreeCache {
 protected:
  /// An entry of 1000 bytes that was last used this many minutes ago.
  fs::path old_entry(const std::string& name, int minutes) {
    fs::create_directories(settings_.folder);
    const fs::path file = settings_.folder / name;
    put(file, std::string(1000, 'x'));
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::minutes(minutes));
    return file;
  }
};

TEST_F(TreeCacheLimit, RemovesTheLongestUnusedEntriesFirstAndCountsThem) {
  const fs::path oldest = old_entry("a.poisetree", 30);
  const fs::path older = old_entry("b.poisetree", 20);
  const fs::path newer = old_entry("c.poisetree", 10);
  const fs::path foreign = old_entry("notes.txt", 1000);
  settings_.limit_bytes = entry_bytes(built_, kKey).size() + 1500;
  ASSERT_TRUE(ask());
  EXPECT_EQ(outcome_, TreeCacheOutcome::Built);
  EXPECT_EQ(evicted_, 2U);
  EXPECT_FALSE(fs::exists(oldest) || fs::exists(older));
  EXPECT_TRUE(fs::exists(newer) && fs::exists(foreign) && fs::exists(entry()));
}

TEST_F(TreeCacheLimit, AHitMakesAnEntryNew) {
  ASSERT_TRUE(ask());
  const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(100);
  fs::last_write_time(entry(), long_ago);
  ASSERT_TRUE(ask());
  EXPECT_EQ(outcome_, TreeCacheOutcome::Hit);
  EXPECT_GT(fs::last_write_time(entry()), long_ago + std::chrono::hours(99));
}

TEST_F(TreeCacheLimit, ATreeThatIsLargerThanTheLimitIsNotKept) {
  const fs::path other = old_entry("a.poisetree", 30);
  settings_.limit_bytes = 100;
  EXPECT_TRUE(same_bits(ask().value(), built_));
  EXPECT_EQ(outcome_, TreeCacheOutcome::Built);
  EXPECT_FALSE(fs::exists(entry()));
  EXPECT_TRUE(fs::exists(other));
}

TEST_F(TreeCacheLimit, WhatADeadWriterLeftGoesAndWhatALivingOneHoldsStays) {
  const fs::path dead = old_entry(".a.poisetree.0.part", 5);
  const fs::path alive = old_entry(".b.poisetree.0.part", 90);
  const int holder = ::open(alive.c_str(), O_RDONLY);
  ASSERT_EQ(::flock(holder, LOCK_EX), 0);
  ASSERT_TRUE(ask());
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_TRUE(fs::exists(alive));
  ::close(holder);
  EXPECT_EQ(evicted_, 0U);
}

class TreeCacheFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"XDG_CACHE_HOME", "HOME"}) {
      const char* value = std::getenv(name);
      before_.emplace_back(name, value != nullptr ? std::optional<std::string>(value) : std::nullopt);
    }
  }
  void TearDown() override {
    for (const auto& [name, value] : before_) set(name.c_str(), value);
  }
  static void set(const char* name, const std::optional<std::string>& value) {
    if (value) {
      ::setenv(name, value->c_str(), 1);
    } else {
      ::unsetenv(name);
    }
  }
  std::vector<std::pair<std::string, std::optional<std::string>>> before_;
};

TEST_F(TreeCacheFolder, FollowsTheXdgConvention) {
  set("HOME", "/h");
  set("XDG_CACHE_HOME", "/x/cache");
  EXPECT_EQ(default_tree_cache_folder(), "/x/cache/poise");
  for (const char* ignored : {"", "relative/cache"}) {
    set("XDG_CACHE_HOME", ignored);
    EXPECT_EQ(default_tree_cache_folder(), "/h/.cache/poise") << ignored;
  }
  set("XDG_CACHE_HOME", std::nullopt);
  EXPECT_EQ(default_tree_cache_folder(), "/h/.cache/poise");
  set("HOME", std::nullopt);
  EXPECT_EQ(default_tree_cache_folder(), "");
  TreeCacheOutcome outcome{};
  EXPECT_TRUE(cached_sphere_tree(test::box_mesh(Vec3(1, 1, 1)), {.depth = 0, .threads = 1}, {}, &outcome));
  EXPECT_EQ(outcome, TreeCacheOutcome::NotWritable);
}

}  // namespace
}  // namespace poise
