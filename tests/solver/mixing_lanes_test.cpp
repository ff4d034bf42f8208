// SPDX-License-Identifier: MIT
#include "solver/iterations/mixing_lanes.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <vector>

#include "collision/instruction_sets.h"

namespace poise::solver {
namespace {

constexpr std::size_t kDepth = AndersonMixing::kDepth;

std::vector<double> numbers(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<double> made(count);
  for (double& value : made) value = number(random);
  return made;
}

TEST(MixingLanes, NoteAStepAndSumProductsInTheOrderOfTheNumbersOnEveryInstructionSet) {
  constexpr std::size_t kCount = 301;
  constexpr std::size_t kStep = 5;
  const std::vector<double> before = numbers(kCount, 1);
  const std::vector<double> after = numbers(kCount, 2);
  const int sets = collision::on_every_instruction_set([&](const char* name) {
    std::vector<double> residual = numbers(kCount, 8);
    std::vector<double> last_after = numbers(kCount, 9);
    std::vector<double> steps = numbers(kDepth * kCount, 10);
    std::vector<double> after_step(kCount);
    double square = 0;
    std::vector<double> expected = steps;
    std::vector<double> expected_after_step(kCount);
    std::vector<double> expected_residual(kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
      expected_residual[i] = after[i] - before[i];
      square += expected_residual[i] * expected_residual[i];
      expected[i * kDepth + kStep] = expected_residual[i] - residual[i];
      expected_after_step[i] = after[i] - last_after[i];
    }
    const NotedStep noted = note_step(before, after, kStep, {residual, last_after, steps, after_step});
    EXPECT_EQ(noted.residual_square, square) << name;
    EXPECT_EQ(steps, expected) << name;
    EXPECT_EQ(after_step, expected_after_step) << name;
    EXPECT_EQ(residual, expected_residual) << name;
    EXPECT_EQ(last_after, after) << name;
    for (std::size_t k = 0; k < kDepth; ++k) {
      double with_step = 0;
      double with_last = 0;
      for (std::size_t i = 0; i < kCount; ++i) {
        with_step += steps[i * kDepth + kStep] * steps[i * kDepth + k];
        with_last += steps[i * kDepth + k] * residual[i];
      }
      EXPECT_EQ(noted.with_step[k], with_step) << name << ", step " << k;
      EXPECT_EQ(noted.with_last[k], with_last) << name << ", step " << k;
    }
  });
  EXPECT_GE(sets, 1);
}

TEST(MixingLanes, SubtractOneStepAfterAnotherOnEveryInstructionSet) {
  const std::vector<double> parts = numbers(3, 3);
  const int sets = collision::on_every_instruction_set([&](const char* name) {
    for (const std::size_t count : {0U, 1U, 3U, 8U, 29U}) {
      const std::vector<std::vector<double>> steps = {numbers(count, 4), numbers(count, 5), numbers(count, 6)};
      const std::vector<const double*> at = {steps[0].data(), steps[1].data(), steps[2].data()};
      std::vector<double> left = numbers(count, 7);
      std::vector<double> expected = left;
      for (std::size_t s = 0; s < steps.size(); ++s) {
        for (std::size_t i = 0; i < count; ++i) expected[i] -= parts[s] * steps[s][i];
      }
      subtract_steps(at, parts, left);
      EXPECT_EQ(left, expected) << name << ", " << count << " numbers";
    }
  });
  EXPECT_GE(sets, 1);
}

}  // namespace
}  // namespace poise::solver
