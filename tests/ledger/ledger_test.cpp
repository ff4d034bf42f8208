// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "ledger/callgrind_profile.h"
#include "ledger/ledger_file.h"
#include "ledger/unit_costs.h"

namespace poise::ledger {
namespace {

constexpr const char* kProfile =
    "# callgrind format\nversion: 1\nevents: Ir\n\n"
    "fl=a.cpp\nfn=poise::step(int (*)(int))\n10 5\n11 7\ncfn=poise::step(int "
    "(*)(int))::{lambda(int)#1}::operator()(int) "
    "const\ncalls=2 30\n12 100\n\n"
    "fn=poise::step(int (*)(int))::{lambda(int)#1}::operator()(int) const\n30 100\n\n"
    "fn=poise::step_back(int)\n40 3\n\ntotals: 115\n";

TEST(CallgrindProfile, CountsAFunctionWithAllThatItCalls) {
  const Result<CallgrindProfile> profile = parse_callgrind_profile(kProfile);
  ASSERT_TRUE(profile.ok());
  EXPECT_EQ(profile.value().total, 115U);
  EXPECT_EQ(instructions_inside(profile.value(), "poise::step"), 112U) << "its lambda is inside of it, once";
  EXPECT_EQ(instructions_inside(profile.value(), "poise::step_back"), 3U);
  EXPECT_EQ(instructions_inside(profile.value(), "poise::ste"), 0U);
}

TEST(CallgrindProfile, CountsAPartThatTheCompilerHasTakenOutOfAFunctionOnce) {
  const Result<CallgrindProfile> profile = parse_callgrind_profile(
      "totals: 60\nfn=solve(int)\n1 10\ncfn=solve(int) [clone .part.0]\ncalls=1 2\n1 45\n2 5\n"
      "fn=solve(int) [clone .part.0]\n2 45\n");
  ASSERT_TRUE(profile.ok());
  EXPECT_EQ(instructions_inside(profile.value(), "solve"), 60U);
}

TEST(CallgrindProfile, IsRefusedWithoutATotalOrFunctions) {
  EXPECT_FALSE(parse_callgrind_profile("").ok());
  EXPECT_FALSE(parse_callgrind_profile("fn=a\n1 2\n").ok());
  EXPECT_FALSE(parse_callgrind_profile("totals: 12\n").ok());
}

TEST(UnitCosts, AreRefusedWhereTheStagesOfTheTableAreNotTheStep) {
  CallgrindProfile profile;
  profile.total = 1000000;
  profile.inclusive["poise::simulation::integrate(int)"] = 940000;
  const Result<EntryCosts> costs = unit_costs("gas", profile, CountedUnits{.frames = 1});
  ASSERT_FALSE(costs.ok());
  EXPECT_NE(costs.error().message.find("94.0 % of the step"), std::string::npos) << costs.error().message;
  EXPECT_TRUE(unit_costs("gas", profile, CountedUnits{.frames = 20}).ok()) << "3,000 instructions of a frame in none";
}

TEST(UnitCosts, AreRefusedWhereUnitsWereCountedAndNoFunctionOfThem) {
  CallgrindProfile profile;
  profile.total = 1000;
  profile.inclusive["poise::simulation::integrate(int)"] = 1000;
  const Result<EntryCosts> costs = unit_costs("gas", profile, CountedUnits{.frames = 1, .expansions = 100});
  ASSERT_FALSE(costs.ok());
  EXPECT_NE(costs.error().message.find("100 units of expansion"), std::string::npos) << costs.error().message;
}

EntryCosts entry(double step, double bodies, double count) {
  return {"gas", {{"step", step, 10}}, {{"body", bodies, count}}};
}

TEST(Ledger, ComparesWithinItsToleranceInBothDirections) {
  Ledger ledger;
  ledger.tolerance = 0.03;
  ledger.entries = {entry(1000, 50, 200)};
  const auto outside = [&](const EntryCosts& now) {
    std::vector<std::string> names;
    for (const Compared& row : compare(ledger, {now})) {
      if (!row.within) names.push_back(row.cost);
    }
    return names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(outside(entry(1029, 50, 200)), Names{});
  EXPECT_EQ(outside(entry(1031, 50, 200)), Names{"step"});
  EXPECT_EQ(outside(entry(969, 50, 200)), Names{"step"}) << "cheaper is a change of the ledger too";
  EXPECT_EQ(outside(entry(1000, 50, 220)), Names{"body count"}) << "the same work is to be counted";
}

TEST(Ledger, ComparesWhatOneSideDoesNotHave) {
  Ledger ledger;
  ledger.entries = {entry(1000, 50, 200)};
  EntryCosts other = entry(1000, 50, 200);
  other.entry = "jacks";
  const std::vector<Compared> rows = compare(ledger, {other});
  ASSERT_EQ(rows.size(), 4U);
  for (const Compared& row : rows) EXPECT_FALSE(row.within) << row.entry << ' ' << row.cost;
}

TEST(Ledger, IsReadAsItWasWritten) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "poise-ledger-test.json";
  Ledger ledger{
      "valgrind-3", "GNU 12", "Release", 0.02, {{"abc", "first"}, {"def", "second"}}, {entry(123456, 7.25, 9)}};
  ASSERT_TRUE(write_ledger(ledger, file).ok());
  const Result<Ledger> read = read_ledger(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().compiler, "GNU 12");
  EXPECT_EQ(read.value().tolerance, 0.02);
  ASSERT_EQ(read.value().changes.size(), 2U);
  EXPECT_EQ(read.value().changes[1].reason, "second");
  ASSERT_EQ(read.value().entries.size(), 1U);
  EXPECT_EQ(read.value().entries[0].per_frame[0].instructions, 123456);
  EXPECT_EQ(read.value().entries[0].per_unit[0].instructions, 7.3);
  std::ofstream(file) << R"({"schema": "poise.ledger/0"})";
  EXPECT_FALSE(read_ledger(file).ok());
  std::ofstream(file) << "not JSON";
  EXPECT_FALSE(read_ledger(file).ok());
  std::filesystem::remove(file);
  EXPECT_FALSE(read_ledger(file).ok());
}

}  // namespace
}  // namespace poise::ledger
