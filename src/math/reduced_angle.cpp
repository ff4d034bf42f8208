// SPDX-License-Identifier: MIT
#include "math/reduced_angle.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

namespace poise::math {
namespace {

// 2 pi / kStepsOfTurn. The first three have 32 bits, so their products with up to 2^20 steps are exact.
constexpr std::array<double, 4> kStepPartsRad{0x1.921fb544p-8, 0x1.0b4611a6p-42, 0x1.3198a2ep-77,
                                              0x1.b839a252049c1p-112};
constexpr double kStepsPerRad = 0x1.45f306dc9c883p+7;
constexpr double kMaxSteps = 1 << 20;
constexpr double kMaxNearRad = 6400;

// The fraction 1 / (2 pi), the first bits first.
constexpr std::array<std::uint32_t, 42> kTurnsPerRad{
    0x28be60dbU, 0x9391054aU, 0x7f09d5f4U, 0x7d4d3770U, 0x36d8a566U, 0x4f10e410U, 0x7f9458eaU, 0xf7aef158U, 0x6dc91b8eU,
    0x909374b8U, 0x01924bbaU, 0x82746487U, 0x3f877ac7U, 0x2c4a69cfU, 0xba208d7dU, 0x4baed121U, 0x3a671c09U, 0xad17df90U,
    0x4e64758eU, 0x60d4ce7dU, 0x272117e2U, 0xef7e4a0eU, 0xc7fe25ffU, 0xf7816603U, 0xfbcbc462U, 0xd6829b47U, 0xdb4d9fb3U,
    0xc9f2c26dU, 0xd3d18fd9U, 0xa797fa8bU, 0x5d49eeb1U, 0xfaf97c5eU, 0xcf41ce7dU, 0xe294a4baU, 0x9afed7ecU, 0x47e35742U,
    0x1580cc11U, 0xbf1edaeaU, 0xfc33ef08U, 0x26bd0d87U, 0x6a78e458U, 0x57b986c2U};
constexpr DoubleDouble kTurnRad{0x1.921fb54442d18p+2, 0x1.1a62633145c07p-52};

/// A fraction of a turn, 192 bits, the last ones first.
using Fraction = std::array<std::uint32_t, 6>;

/// 32 bits of 1 / (2 pi) from the bit with the weight 2^-(bit + 1) on.
std::uint32_t turns_per_rad_from(int bit) {
  const auto word = [](int i) {
    return i < 0 || i >= static_cast<int>(kTurnsPerRad.size()) ? 0U : kTurnsPerRad[static_cast<std::size_t>(i)];
  };
  const int first = (bit + 64) / 32 - 2;  // rounded down for a bit from -64 on
  const int shift = bit - 32 * first;
  return shift == 0 ? word(first) : word(first) << shift | word(first + 1) >> (32 - shift);
}

/// The fraction of significand * 2^exponent / (2 pi), with an error below 2^-138.
Fraction fraction_of_turn(std::uint64_t significand, int exponent) {
  Fraction product{};
  for (int half = 0; half < 2; ++half) {
    const std::uint64_t factor = half == 0 ? significand & 0xffffffffU : significand >> 32;
    std::uint64_t carry = 0;
    for (std::size_t i = static_cast<std::size_t>(half); i < product.size(); ++i) {
      const int from_last = static_cast<int>(i) - half;
      const std::uint64_t bits = turns_per_rad_from(exponent + 32 * (5 - from_last));
      const std::uint64_t sum = factor * bits + product[i] + carry;
      product[i] = static_cast<std::uint32_t>(sum);
      carry = sum >> 32;
    }
  }
  return product;
}

/// Payne and Hanek 1983: only those bits of 1 / (2 pi) are used that make up the fraction of a turn.
ReducedAngle reduced_far(double angle_rad) {
  const auto bits = std::bit_cast<std::uint64_t>(std::abs(angle_rad));
  const std::uint64_t significand = (bits & ((1ULL << 52) - 1)) | 1ULL << 52;
  Fraction rest = fraction_of_turn(significand, static_cast<int>(bits >> 52) - 1075);
  // The nearest step, and what is left over from there.
  std::uint32_t steps = rest[5] >> 22;
  rest[5] &= (1U << 22) - 1;
  const bool above = rest[5] >= 1U << 21;
  if (above) {
    ++steps;
    rest[5] |= ~((1U << 22) - 1);
    for (std::uint32_t& word : rest) word = ~word;  // all but 2^-192
  }
  DoubleDouble turns;
  double weight = 0x1p-192;
  for (const std::uint32_t word : rest) {
    const DoubleDouble sum = exact_sum(word * weight, turns.high);
    turns = ordered_sum(sum.high, sum.low + turns.low);
    weight *= 0x1p32;
  }
  if (above) turns = -turns;
  DoubleDouble rest_rad = turns * kTurnRad;
  if (angle_rad < 0) {
    rest_rad = -rest_rad;
    steps = kStepsOfTurn - steps;
  }
  return {steps % kStepsOfTurn, rest_rad};
}

}  // namespace

ReducedAngle reduced(double angle_rad) {
  if (!(std::abs(angle_rad) < kMaxNearRad)) return reduced_far(angle_rad);
  static_assert(kMaxNearRad * kStepsPerRad < kMaxSteps);
  const double steps = std::floor(angle_rad * kStepsPerRad + 0.5);
  if (steps == 0) return {0, {angle_rad, 0}};
  const DoubleDouble first = exact_sum(angle_rad, -(steps * kStepPartsRad[0]));
  const DoubleDouble second = exact_sum(first.high, -(steps * kStepPartsRad[1]));
  const DoubleDouble third = exact_sum(second.high, -(steps * kStepPartsRad[2]));
  const double low = (first.low + second.low) + (third.low - steps * kStepPartsRad[3]);
  return {static_cast<std::uint32_t>(static_cast<std::int32_t>(steps)) % kStepsOfTurn, ordered_sum(third.high, low)};
}

}  // namespace poise::math
