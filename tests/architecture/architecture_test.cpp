// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "architecture/old_words.h"
#include "architecture/source_rules.h"

namespace poise::tests {
namespace {

const std::string kLicence = "// SPDX-License-Identifier: MIT\n";

std::vector<std::string> broken_by(const std::string& path, const std::string& line) {
  return broken_rules(path, kLicence + line + "\n");
}

struct Planted {
  std::string path;
  std::string line;
  std::string rule;  // a part of the message
};

void PrintTo(const Planted& planted, std::ostream* out) { *out << planted.path; }

class PlantedViolation : public testing::TestWithParam<Planted> {};

TEST_P(PlantedViolation, IsFoundAtItsLine) {
  const std::vector<std::string> broken = broken_by(GetParam().path, GetParam().line);
  ASSERT_EQ(broken.size(), 1U) << GetParam().line;
  EXPECT_NE(broken[0].find(GetParam().path + ":2: "), std::string::npos) << broken[0];
  EXPECT_NE(broken[0].find(GetParam().rule), std::string::npos) << broken[0];
}

INSTANTIATE_TEST_SUITE_P(
    OfEveryRule, PlantedViolation,
    testing::Values(
        Planted{"src/collision/a.h", "#include \"solver/impulse.h\"", "may not include solver"},
        Planted{"src/geometry/a.h", "#include \"dynamics/body_store.h\"", "may not include dynamics"},
        Planted{"src/geometry/a.h", "#include \"poise/world.h\"", "may not include interface"},
        Planted{"src/frame/a.cpp", "#  include \"poise/scene/scene.h\"", "may not include scene"},
        Planted{"src/parallel/a.cpp", "#include \"poise/scheduler/policy.h\"", "may not include scheduler"},
        Planted{"src/scene/a.cpp", "#include \"app/run_command.h\"", "may not include app"},
        Planted{"src/record/a.cpp", "#include \"capture/capture.h\"", "may not include capture"},
        Planted{"src/capture/a.cpp", "#include \"app/refusal.h\"", "may not include app"},
        Planted{"src/sweep/a.cpp", "#include \"app/refusal.h\"", "may not include app"},
        Planted{"src/sweep/a.cpp", "#include \"capture/capture.h\"", "may not include capture"},
        Planted{"src/sweep/a.cpp", "const auto now = SteadyClock::now();", "time is an argument"},
        Planted{"src/scene/a.cpp", "#include \"sweep/trial.h\"", "may not include sweep"},
        Planted{"src/app/a.cpp", "#include \"studies/study_list.h\"", "may not include bench"},
        Planted{"src/frame/a.cpp", "#include \"oracle/oracle_mesh.h\"", "may not include bench"},
        Planted{"include/poise/mesh.h", "#include \"geometry/weld.h\"", "public ones alone"},
        Planted{"scheduler/a.cpp", "#include \"poise/types.h\"", "its own headers and src/math alone"},
        Planted{"include/poise/scheduler/a.h", "#include \"math/functions.h\"", "src/math alone"},
        Planted{"src/math/a.cpp", "#include \"poise/scheduler/policy.h\"", "may not include scheduler"},
        Planted{"scheduler/a.cpp", "#include <Eigen/Core>", "standard library alone"},
        Planted{"include/poise/scheduler/a.h", "#include <time.h>", "standard library alone"},
        Planted{"scheduler/a.cpp", "#include <mutex>", "src/parallel"},
        Planted{"scheduler/a.cpp", "std::this_thread::yield();", "src/parallel"},
        Planted{"scheduler/a.cpp", "std::jthread worker(work);", "src/parallel"},
        Planted{"scheduler/a.cpp", "flag_.wait(0);", "src/parallel"},
        Planted{"src/frame/a.cpp", "#include <mutex>", "src/parallel"},
        Planted{"src/geometry/a.cpp", "#include <tbb/parallel_for.h>", "src/parallel"},
        Planted{"src/collision/a.cpp", "  std::atomic<int> next{0};", "src/parallel"},
        Planted{"src/app/a.cpp", "const std::jthread worker(work);", "src/parallel"},
        Planted{"src/geometry/a.cpp", "std::stop_source stop;", "src/parallel"},
        Planted{"src/app/a.cpp", "std::stop_callback on_stop(token, [] {});", "src/parallel"},
        Planted{"scheduler/a.cpp", "bool spent(const std::stop_token& stop);", "src/parallel"},
        Planted{"scheduler/a.cpp", "#include <stop_token>", "src/parallel"},
        Planted{"src/solver/a.cpp", "const auto now = std::chrono::steady_clock::now();", "time is an argument"},
        Planted{"scheduler/a.cpp", "const auto now = Clock::now();", "time is an argument"},
        Planted{"include/poise/world.h", "const auto now = SteadyClock::now();", "time is an argument"},
        Planted{"src/scene/a.cpp", "std::cout << 1;", "neither prints"},
        Planted{"src/geometry/a.cpp", "if (bad) abort();", "neither prints"},
        Planted{"src/geometry/a.cpp", "std::fprintf(stderr, \"bad\");", "neither prints"},
        Planted{"src/app/a.cpp", "fmt::print(stderr, \"{}\", why);", "print_error prints"},
        Planted{"src/assets/cache/a.cpp", "const int file = ::open(name, O_RDONLY);", "opens what is read"},
        Planted{"src/scene/a.cpp", "std::FILE* file = std::fopen(name, how);", "opens what is read"},
        Planted{"src/solver/a.h", "inline void prefetch_rows(const Rows& rows);", "only prefetches"},
        Planted{"src/geometry/a.cpp", "const double x = std::sin(angle);", "src/math has the like"},
        Planted{"src/geometry/a.cpp", "const auto wave = &std::sin;", "src/math has the like"},
        Planted{"src/geometry/a.cpp", "x = numext::sin(angle) + ::std::exp(angle);", "src/math has the like"},
        Planted{"src/frame/a.cpp", "const double x = std::cyl_bessel_j(0, y);", "src/math has the like"},
        Planted{"src/frame/a.cpp", "const Vec3 x = Vec3::Random();", "standard libraries"},
        Planted{"src/frame/a.cpp", "std::ranges::shuffle(order, random);", "standard libraries"},
        Planted{"src/solver/a.cpp", "x = hn::ApproximateReciprocalSqrt(y);", "differs between processors"},
        Planted{"src/geometry/a.cpp", "return 2 * ::atan2f (y, x);", "src/math has the like"},
        Planted{"src/math/a.cpp", "return std::log1p(x);", "src/math has the like"},
        Planted{"scheduler/a.cpp", "score = pow(score, 2);", "src/math has the like"},
        Planted{"src/frame/a.cpp", "weights.array().exp().sum();", "src/math has the like"},
        Planted{"src/scene/a.cpp", "Eigen::AngleAxisd(turn, axis)", "src/math has the like"},
        Planted{"src/world/a.cpp", "state = from.slerp(share, to);", "src/math has the like"},
        Planted{"src/scene/a.cpp", "std::normal_distribution<double> size;", "between standard libraries"},
        Planted{"src/scene/a.cpp", "std::shuffle(a.begin(), a.end(), random);", "standard libraries"},
        Planted{"python/src/a.cpp", "std::mutex lock;", "threads"},
        Planted{"python/src/a.cpp", "printf(\"%d\", 1);", "neither prints"},
        Planted{"docs/a.md",
                "cd /ho"
                "me/someone/poise",
                "one machine"},
        Planted{"scenes/a.json",
                "\"file\": \"/tm"
                "p/cow.obj\"",
                "one machine"},
        Planted{"run.sh",
                "curl https://registry.npm"
                "js.org/three",
                "package registry"}));

class Allowed : public testing::TestWithParam<Planted> {};

TEST_P(Allowed, IsNotReported) { EXPECT_EQ(broken_by(GetParam().path, GetParam().line), std::vector<std::string>{}); }

INSTANTIATE_TEST_SUITE_P(
    WhatEachRoomMayDo, Allowed,
    testing::Values(Planted{"src/solver/a.cpp", "#include \"collision/contact.h\"", ""},
                    Planted{"src/dynamics/a.cpp", "#include \"poise/world.h\"", ""},
                    Planted{"src/frame/a.cpp", "#include \"poise/scheduler/policy.h\"", ""},
                    Planted{"src/frame/a.cpp", "const auto now = SteadyClock::now();", ""},
                    Planted{"src/parallel/a.cpp", "#include <atomic>", ""},
                    Planted{"include/poise/sphere_tree.h", "#include <stop_token>", ""},
                    Planted{"src/geometry/a.cpp", "void build(const std::stop_token& stop);", ""},
                    Planted{"scheduler/a.cpp", "#include <cmath>", ""},
                    Planted{"scheduler/a.cpp", "#include \"math/functions.h\"", ""},
                    Planted{"src/geometry/a.cpp", "const double x = math::sin(angle);", ""},
                    Planted{"src/geometry/a.cpp", "root = std::sqrt(std::abs(x)) + std::floor(std::fmod(x, y));", ""},
                    Planted{"src/math/a.cpp", "double sin(double angle_rad) {", ""},
                    Planted{"src/app/a.cpp", "const double x = std::log10(least);", ""},
                    Planted{"src/scene/run/run_statistics.cpp", "std::exp(-x)", ""},
                    Planted{"src/world/a.cpp", "decision_log(world).log_of(pair);", ""},
                    Planted{"include/poise/scheduler/a.h", "#include <atomic>", ""},
                    Planted{"include/poise/scheduler/a.h", "std::atomic<int> left_{0};", ""},
                    Planted{"src/app/a.cpp", "std::cout << 1;", ""},
                    Planted{"src/assets/files/open_file.cpp", "const int file = ::open(name, O_RDONLY);", ""},
                    Planted{"src/solver/a.h", "HWY_INLINE void prefetch_rows(const Rows& rows) {", ""},
                    Planted{"python/src/a.cpp", "#include \"record/record_file.h\"", ""},
                    Planted{"src/scene/a.cpp", "std::snprintf(text, size, \"%d\", 1);", ""},
                    Planted{"src/collision/a.cpp", "// a std::mutex would cost more; see Clock::now()", ""},
                    Planted{"src/collision/a.cpp", "const char* text = \"std::mutex\";", ""},
                    Planted{"scenes/a.json", "\"file\": \"/usr/share/assimp/models/OBJ/box.obj\"", ""},
                    Planted{"docs/a.md",
                            "see https://example.org/wo"
                            "rk/paper",
                            ""}));

TEST(SourceRules, CountTheLinesOfAFile) {
  std::string text = kLicence;
  for (int i = 0; i < 499; ++i) text += "\n";
  EXPECT_EQ(broken_rules("src/scene/a.cpp", text), std::vector<std::string>{});
  EXPECT_EQ(broken_rules("src/scene/a.cpp", text + "\n").size(), 1U);
  EXPECT_EQ(broken_rules("scenes/a.json", text + "\n"), std::vector<std::string>{}) << "data may be long";
}

TEST(SourceRules, CountTheLinesOfAFunction) {
  const auto body = [](int lines) {
    std::string text;
    for (int i = 0; i < lines; ++i) text += "  a();\n";
    return text;
  };
  EXPECT_EQ(broken_rules("src/scene/a.cpp", kLicence + "void f(int a,\n       int b) {\n" + body(78) + "}\n"),
            std::vector<std::string>{});
  EXPECT_EQ(broken_rules("bench/a.cpp", kLicence + "void f(int a,\n       int b) {\n" + body(79) + "}\n").size(), 1U);
  EXPECT_EQ(broken_rules("src/scene/a.h", kLicence + "template <class T>\nstruct S {\n" + body(99) + "};\n"),
            std::vector<std::string>{})
      << "a type may be longer";
}

TEST(SourceRules, AskForTheLicenceInTheFirstLine) {
  EXPECT_EQ(broken_rules("src/scene/a.h", "#pragma once\n").size(), 1U);
  EXPECT_EQ(broken_rules("bench/bench_a.cpp", "").size(), 1U);
}

TEST(CodeOnly, BlanksCommentsAndLiteralsAndKeepsLinesInPlace) {
  EXPECT_EQ(code_only("a /* b\nc */ d // e\nf"), "a     \n     d     \nf");
  EXPECT_EQ(code_only(R"(x = "a\"b"; y)"), "x =       ; y");
  EXPECT_EQ(code_only("R\"q(\"//)q\" z"), "           z");
  EXPECT_EQ(code_only("n = 1'000; c = '\"'; d"), "n = 1'000; c =    ; d");
}

TEST(OldWords, AreFoundInCodeDocsAndScenes) {
  const std::vector<std::string> code = old_words("src/solver/a.h", "int a;\nRestPlace place;\n");
  ASSERT_EQ(code.size(), 1U);
  EXPECT_EQ(code[0].find("src/solver/a.h:2: "), 0U) << code[0];
  EXPECT_NE(code[0].find("ContactPoint"), std::string::npos) << code[0];
  for (const char* line : {"double likely_m = 0;", "std::vector<PairMemory> all;", "report.kept_apart",
                           "\"patch_visits\"", "tail_patch_visits,", "// the job is given up", "the exact judge",
                           "laid out by rows", "MeshVerdict verdict_of", "wake_stirred(); // stir", "RestSolverTest"})
    EXPECT_FALSE(old_words("docs/a.md", line).empty()) << line;
  EXPECT_EQ(old_words("scenes/a.json", "{\"kept_apart\": 1, \"verdict\": 2}").size(), 2U);
}

TEST(OldWords, LeaveOtherWordsAlone) {
  for (const char* line : {"the stirrup", "rubber", "overlay outer", "oversight of insight", "remover", "keep_kept",
                           "a place in memory", "carbonyields_", "adjudge"})
    EXPECT_EQ(old_words("src/solver/a.cpp", line), std::vector<std::string>{}) << line;
}

TEST(OldWords, MayStandInTheChangelogAndInNoPicture) {
  EXPECT_TRUE(old_words("CHANGELOG.md", "RestPlace is ContactPoint").empty());
  EXPECT_TRUE(old_words("docs/images/a.png", "RestPlace").empty());
  EXPECT_FALSE(old_words("docs/a.md", "RestPlace is ContactPoint").empty());
}

// Folders of a checkout other than sources: builds, results, files of version control and editors.
bool is_skipped(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 6> kSkipped{"build", "out", ".git", ".cache", "node_modules", "shared"};
  const std::string name = path.filename().string();
  return std::ranges::find(kSkipped, name) != kSkipped.end();
}

TEST(Architecture, HoldsInEveryFileOfTheRepository) {
  const std::filesystem::path root = POISE_SOURCE_DIR;
  std::size_t files = 0;
  std::string broken;
  for (auto it = std::filesystem::recursive_directory_iterator(root); it != std::filesystem::end(it); ++it) {
    if (is_skipped(it->path())) {  // .git is a file in a checkout that is one of several
      if (it->is_directory()) it.disable_recursion_pending();
      continue;
    }
    const std::string path = it->path().lexically_relative(root).generic_string();
    const std::string ending = it->path().extension().string();
    const bool is_binary =
        ending == ".png" || ending == ".webp" || ending == ".stl" || ending == ".ply" || ending == ".glb";
    if (!it->is_regular_file() || is_binary || ending == ".obj") continue;
    std::ifstream file(it->path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    for (const std::string& line : broken_rules(path, text)) broken += line + "\n";
    for (const std::string& line : old_words(path, text)) broken += line + "\n";
    ++files;
  }
  EXPECT_GT(files, 30U) << "looked in the wrong place: " << root;
  EXPECT_EQ(broken, "");
}

}  // namespace
}  // namespace poise::tests
