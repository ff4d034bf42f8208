// SPDX-License-Identifier: MIT
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "math/double_double.h"
#include "math/functions.h"

namespace poise::math {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr DoubleDouble kLog2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
constexpr DoubleDouble kPerLog2{0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56};

/// Powers of two, 2^0 to 2^(127/128), to about 2^-97.
constexpr std::size_t kParts = 128;
constexpr std::array<DoubleDouble, kParts> powers_of_two() {
  const DoubleDouble step = kLog2 * DoubleDouble{1.0 / kParts, 0};
  DoubleDouble factor{1, 0};
  for (int n = 12; n > 0; --n) factor = DoubleDouble{1, 0} + step * factor / DoubleDouble{static_cast<double>(n), 0};
  std::array<DoubleDouble, kParts> powers{};
  powers[0] = {1, 0};
  for (std::size_t i = 1; i < kParts; ++i) powers[i] = powers[i - 1] * factor;
  return powers;
}

constexpr auto kPowers = powers_of_two();

/// For x near c = (i + kFirstCenter) / 256: a factor near 1 / c and the logarithm of 1 / factor. c goes from sqrt(1/2)
/// to sqrt(2).
constexpr std::size_t kFirstCenter = 181;
constexpr std::size_t kCenters = 182;
struct Center {
  double factor = 1;
  DoubleDouble log;
};
constexpr std::array<Center, kCenters> centers() {
  std::array<DoubleDouble, 22> per_odd{};
  for (std::size_t n = 0; n < per_odd.size(); ++n)
    per_odd[n] = DoubleDouble{2, 0} / DoubleDouble{static_cast<double>(2 * n + 1), 0};
  std::array<Center, kCenters> all{};
  for (std::size_t i = 0; i < kCenters; ++i) {
    const double factor = 256.0 / static_cast<double>(i + kFirstCenter);
    // log(1 / f) = 2 atanh((1 - f) / (1 + f))
    const DoubleDouble z = exact_sum(1, -factor) / exact_sum(1, factor);
    const DoubleDouble square = z * z;
    DoubleDouble series{0, 0};
    for (std::size_t n = per_odd.size(); n-- > 0;) series = per_odd[n] + square * series;
    all[i] = {factor, z * series};
  }
  return all;
}

constexpr auto kCentersOfLog = centers();

/// 2^exponent, for exponents of normal numbers.
double power_of_two(int exponent) { return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52); }

/// exp(x), of any x but NaN.
double exp_of(DoubleDouble x) {
  if (x.high > 710) return kInfinity;
  if (x.high < -746) return 0;
  // log(2) / 128. The first two have 32 bits, so their products with up to 2^18 are exact.
  constexpr std::array<double, 3> kPart{0x1.62e42feep-8, 0x1.a39ef356p-40, 0x1.93c7673007e5fp-72};
  const double parts = std::floor(x.high * 0x1.71547652b82fep+7 + 0.5);
  const DoubleDouble first = exact_sum(x.high, -(parts * kPart[0]));
  const DoubleDouble second = exact_sum(first.high, -(parts * kPart[1]));
  const DoubleDouble rest = ordered_sum(second.high, first.low + (second.low - parts * kPart[2]) + x.low);
  const auto count = static_cast<int>(parts);
  const auto whole = static_cast<int>(std::floor(parts / kParts));
  const DoubleDouble power = kPowers[static_cast<std::size_t>(count - whole * static_cast<int>(kParts))];
  // exp(r) - 1 - r, with r below 0.0028
  const double r = rest.high;
  const double series = 1.0 / 6 + r * (1.0 / 24 + r * (1.0 / 120 + r * (1.0 / 720 + r * (1.0 / 5040))));
  const double less_r = r * r * (0.5 + r * series) + r * rest.low;
  const DoubleDouble slope = exact_product(power.high, r);
  const DoubleDouble sum = ordered_sum(power.high, slope.high);
  const double result =
      sum.high + (sum.low + (power.high * (less_r + rest.low) + (power.low + slope.low + power.low * r)));
  // In two steps, so that neither factor is above or below all doubles.
  const int half = whole / 2;
  return result * power_of_two(half) * power_of_two(whole - half);
}

/// The logarithm of a positive finite x.
DoubleDouble log_of(double x) {
  int exponent = 0;
  if (x < 0x1p-1022) {
    x *= 0x1p54;
    exponent = -54;
  }
  const auto bits = std::bit_cast<std::uint64_t>(x);
  // From sqrt(1/2) to sqrt(2), so that the terms do not cancel near 1.
  constexpr std::uint64_t kSqrtHalf = 0x3fe6a09e667f3bcdULL;
  const auto shifted = static_cast<std::int64_t>(bits - kSqrtHalf) >> 52;
  exponent += static_cast<int>(shifted);
  const double m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(shifted) << 52));
  // The multiple of 1/256 that is nearest to m.
  const std::size_t nearest = static_cast<std::size_t>(m * 512 + 1) / 2;
  const Center& center = kCentersOfLog[nearest - kFirstCenter];
  const DoubleDouble product = exact_product(m, center.factor);
  const DoubleDouble rest = ordered_sum(product.high - 1, product.low);
  // log(1 + r) - r + r^2 / 2, with r below 0.0028
  const double r = rest.high;
  const DoubleDouble square = exact_product(r, r);
  const double series =
      1.0 / 3 - r * (1.0 / 4 - r * (1.0 / 5 - r * (1.0 / 6 - r * (1.0 / 7 - r * (1.0 / 8 - r * (1.0 / 9))))));
  const double cubic = r * square.high * series;
  // log(2) in two parts, the first of 40 bits, so that its products with exponents are exact.
  const auto whole = static_cast<double>(exponent);
  const DoubleDouble first = exact_sum(whole * 0x1.62e42fefa2p-1, center.log.high);
  const DoubleDouble second = exact_sum(first.high, r);
  const DoubleDouble third = exact_sum(second.high, -0.5 * square.high);
  const double low = (cubic - 0.5 * square.low - r * rest.low) +
                     (rest.low + center.log.low + whole * 0x1.9ef35793c7673p-41 + first.low + second.low + third.low);
  return exact_sum(third.high, low);
}

}  // namespace

double exp(double x) { return std::isnan(x) ? x : exp_of({x, 0}); }

double log(double x) {
  if (!(x > 0)) return x == 0 ? -kInfinity : kNan;
  return std::isinf(x) ? x : log_of(x).high;
}

double log2(double x) {
  if (!(x > 0)) return x == 0 ? -kInfinity : kNan;
  return std::isinf(x) ? x : (log_of(x) * kPerLog2).high;
}

double pow(double base, double exponent) {
  if (exponent == 0 || base == 1) return 1;
  if (std::isnan(base) || std::isnan(exponent) || base < 0) return kNan;
  const bool grows = (base > 1) == (exponent > 0);
  if (base == 0 || std::isinf(base) || std::isinf(exponent)) return grows ? kInfinity : 0;
  const DoubleDouble log = log_of(base);
  if (std::abs(log.high * exponent) > 800) return grows ? kInfinity : 0;
  const DoubleDouble product = exact_product(log.high, exponent);
  return exp_of(ordered_sum(product.high, product.low + log.low * exponent));
}

double cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  double size = std::abs(x);
  int third = 0;
  if (size < 0x1p-1022) {
    size *= 0x1p54;
    third = -18;
  }
  // size = m * 2^(3 k), with m from 1 to 8
  const auto bits = std::bit_cast<std::uint64_t>(size);
  const int exponent = static_cast<int>(bits >> 52) - 1023;
  const int k = (exponent + 1080) / 3 - 360;  // rounded down
  third += k;
  const double m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(static_cast<std::int64_t>(3 * k)) << 52));
  // Halley's method triples the digits each time, from a start within 6 % to 2^-38; the last step doubles them.
  double root = 0.80 + m * (0.27 - m * 0.0153);
  for (int round = 0; round < 2; ++round) {
    const double cube = root * root * root;
    root *= (cube + 2 * m) / (2 * cube + m);
  }
  const DoubleDouble square = exact_product(root, root);
  const DoubleDouble cube = square * DoubleDouble{root, 0};
  const double nearest = root + ((m - cube.high) - cube.low) / (3 * square.high);
  return std::copysign(nearest * power_of_two(third), x);
}

}  // namespace poise::math
