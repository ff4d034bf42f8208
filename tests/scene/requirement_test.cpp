// SPDX-License-Identifier: MIT
#include "scene/run/requirement.h"

#include <gtest/gtest.h>

namespace poise::io {
namespace {

const std::vector<NamedFigure> kFigures{
    {"misses.rate", 0.25}, {"frame_ms.p99", 12.5}, {"levels.mean", std::nullopt}, {"miss_rate", 0.25}};

std::vector<std::string> failed(const std::string& text) {
  const Result<Requirement> requirement = parse_requirement(text);
  if (!requirement) return {"refused: " + requirement.error().message};
  return failed_comparisons(requirement.value(), kFigures);
}

TEST(Requirement, HoldsWhenEveryComparisonDoes) {
  for (const char* text :
       {"miss_rate<0.3", "miss_rate <= 0.25 && frame_ms.p99 < 16.7", "0.2 < misses.rate", "frame_ms.p99 == 12.5",
        "frame_ms.p99 != 12", "frame_ms.p99>=+1.25e1", "frame_ms.p99 > miss_rate", " 1>-1 "}) {
    EXPECT_TRUE(failed(text).empty()) << text << ": " << failed(text).front();
  }
}

TEST(Requirement, SaysWhichComparisonFailedAndBothValues) {
  EXPECT_EQ(failed("miss_rate<0.01 && frame_ms.p99<16.7"),
            std::vector<std::string>{"miss_rate<0.01 does not hold: miss_rate = 0.25"});
  EXPECT_EQ(
      failed("frame_ms.p99 < misses.rate"),
      std::vector<std::string>{"frame_ms.p99 < misses.rate does not hold: frame_ms.p99 = 12.5, misses.rate = 0.25"});
  EXPECT_EQ(failed("miss_rate > 1 && frame_ms.p99 > 20").size(), 2U);
  EXPECT_EQ(failed("miss_rate != 0.25").size(), 1U);
  EXPECT_EQ(failed("miss_rate == 0.26").size(), 1U);
  EXPECT_EQ(failed("miss_rate >= 0.26").size(), 1U);
}

TEST(Requirement, NeverHoldsForAFigureThatTheRunDoesNotDefine) {
  EXPECT_EQ(failed("levels.mean >= 0"),
            std::vector<std::string>{"levels.mean >= 0 does not hold: levels.mean is not defined for this run"});
  EXPECT_EQ(failed("levels.mean < 100").size(), 1U);
}

TEST(Requirement, RefusesWhatIsNoComparison) {
  const auto refusal = [](const char* text) { return parse_requirement(text).error().message; };
  EXPECT_EQ(refusal(""), "a comparison is missing");
  EXPECT_EQ(refusal("a<1 &&"), "a comparison is missing");
  EXPECT_EQ(refusal("&& a<1"), "a comparison is missing");
  EXPECT_EQ(refusal("miss_rate"),
            "\"miss_rate\" must be a comparison by one of < <= > >= == !=, such as miss_rate < 0.01");
  EXPECT_EQ(refusal("miss_rate = 1"),
            "\"miss_rate = 1\" must be a comparison by one of < <= > >= == !=, such as miss_rate < 0.01");
  EXPECT_EQ(refusal("a < "), "\"\" must be a name or a number");
  EXPECT_EQ(refusal("a < 1 < 2"), "\"1 < 2\" must be a name or a number");
  EXPECT_EQ(refusal("a < 1e999"), "\"1e999\" is out of range");
  EXPECT_EQ(refusal("a < nan"), "\"nan\" must be a name or a number");
  EXPECT_EQ(refusal("a < inf"), "\"inf\" must be a name or a number");
  EXPECT_EQ(refusal("a < 1x"), "\"1x\" must be a name or a number");
  EXPECT_EQ(refusal("a < 1 || b < 2"), "\"1 || b < 2\" must be a name or a number");
}

TEST(Requirement, RefusesANameThatNoRunHas) {
  const Result<Requirement> requirement = parse_requirement("frame_ms.p9 < 1");
  ASSERT_TRUE(requirement);
  EXPECT_EQ(check_names(requirement.value(), kFigures).error().message,
            "no figure of a run is called \"frame_ms.p9\"; did you mean \"frame_ms.p99\"?");
  EXPECT_TRUE(check_names(parse_requirement("levels.mean < 1 && 1 < 2").value(), kFigures));
}

}  // namespace
}  // namespace poise::io
