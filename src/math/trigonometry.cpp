// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "math/double_double.h"
#include "math/functions.h"
#include "math/reduced_angle.h"

namespace poise::math {
namespace {

constexpr DoubleDouble kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
constexpr DoubleDouble kHalfPi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
constexpr DoubleDouble kStepRad{0x1.921fb54442d18p-8, 0x1.1a62633145c07p-62};
constexpr std::uint32_t kQuarter = kStepsOfTurn / 4;

/// Below this, sin(x) rounds to x, and tan(x) as well.
constexpr double kTiny = 0x1p-27;

/// Sines of 0 to a quarter turn by steps, to about 2^-96: the sine and cosine of one step by their series, the others
/// by the addition theorems.
constexpr std::array<DoubleDouble, kQuarter + 1> sines_of_steps() {
  const DoubleDouble square = kStepRad * kStepRad;
  DoubleDouble sine{1, 0};
  DoubleDouble cosine{1, 0};
  for (int n = 8; n > 0; --n) {
    const double even = 2 * n * (2 * n + 1);
    const double odd = 2 * n * (2 * n - 1);
    sine = DoubleDouble{1, 0} - square * sine / DoubleDouble{even, 0};
    cosine = DoubleDouble{1, 0} - square * cosine / DoubleDouble{odd, 0};
  }
  sine = sine * kStepRad;
  std::array<DoubleDouble, kQuarter + 1> sines{};
  DoubleDouble cosine_so_far{1, 0};
  for (std::size_t i = 1; i <= kQuarter; ++i) {
    sines[i] = sines[i - 1] * cosine + cosine_so_far * sine;
    cosine_so_far = cosine_so_far * cosine - sines[i - 1] * sine;
  }
  sines[kQuarter] = {1, 0};
  return sines;
}

constexpr auto kSines = sines_of_steps();

/// Arc tangents of i / 128, by the differences atan(x) - atan(y) = atan((x - y) / (1 + x y)).
constexpr std::size_t kSlopes = 128;
constexpr std::array<DoubleDouble, kSlopes + 1> arc_tangents() {
  std::array<DoubleDouble, kSlopes + 1> angles{};
  for (std::size_t i = 1; i <= kSlopes; ++i) {
    const double below = static_cast<double>(kSlopes * kSlopes + i * (i - 1));
    const DoubleDouble slope = DoubleDouble{kSlopes, 0} / DoubleDouble{below, 0};
    const DoubleDouble square = slope * slope;
    DoubleDouble series{0, 0};
    for (int n = 17; n > 0; n -= 2)
      series = DoubleDouble{1, 0} / DoubleDouble{static_cast<double>(n), 0} - square * series;
    angles[i] = angles[i - 1] + slope * series;
  }
  return angles;
}

constexpr auto kArcTangents = arc_tangents();

/// The sine of the angle that `turned` quarter turns and the angle make. Where s and c are the sine and cosine of whole
/// steps and r is the rest, sin = s + (c r + s (cos r - 1) + c (sin r - r)), with r below 0.0031.
DoubleDouble sine_of(const ReducedAngle& angle, std::uint32_t turned) {
  const std::uint32_t steps = angle.steps + turned * kQuarter;
  const std::uint32_t within = steps % kQuarter;
  const bool crosswise = (steps / kQuarter) % 2 == 1;
  DoubleDouble s = kSines[crosswise ? kQuarter - within : within];
  DoubleDouble c = kSines[crosswise ? within : kQuarter - within];
  if (crosswise) c = -c;
  if ((steps / kQuarter) % 4 >= 2) {
    s = -s;
    c = -c;
  }
  const double r = angle.rest_rad.high;
  const double square = r * r;
  const double cosine_less_1 = square * (-0.5 + square * (1.0 / 24 - square * (1.0 / 720))) - r * angle.rest_rad.low;
  const double sine_less_r = r * square * (-1.0 / 6 + square * (1.0 / 120 - square * (1.0 / 5040)));
  const DoubleDouble slope = exact_product(c.high, r);
  const DoubleDouble sum = exact_sum(s.high, slope.high);
  const double low =
      (s.high * cosine_less_1 + c.high * sine_less_r) + (s.low + slope.low + c.high * angle.rest_rad.low + c.low * r);
  return exact_sum(sum.high, sum.low + low);
}

double value(DoubleDouble x) { return x.high + x.low; }

/// Up to here the first term of a series is so much larger than the others that plain sums do; bodies turn by less in a
/// step, so this is the path that has to be fast.
constexpr double kSmallRad = 0.125;

double small_sine(double x) {
  const double square = x * x;
  const double series =
      -1.0 / 6 +
      square *
          (1.0 / 120 +
           square * (-1.0 / 5040 + square * (1.0 / 362880 + square * (-1.0 / 39916800 + square * (1.0 / 6227020800)))));
  return x + x * (square * series);
}

double small_cosine(double x) {
  const double square = x * x;
  const double series =
      1.0 / 24 +
      square * (-1.0 / 720 + square * (1.0 / 40320 + square * (-1.0 / 3628800 + square * (1.0 / 479001600))));
  return 1 - (0.5 * square - square * square * series);
}

/// The arc tangent of y / x, neither below 0. The larger is between 2^-52 and 4, y at least 2^-40 x.
DoubleDouble angle_of(double y, double x) {
  const bool steep = y > x;
  if (steep) std::swap(x, y);
  const double index = std::floor(y / x * kSlopes + 0.5);
  const double slope = index / kSlopes;
  // atan(y / x) = atan(slope) + atan((y - slope x) / (x + slope y)), the latter below 1/256.
  const DoubleDouble under = exact_product(slope, x);
  const DoubleDouble over = exact_product(slope, y);
  DoubleDouble rise = exact_sum(y, -under.high);
  rise.low -= under.low;
  DoubleDouble run = ordered_sum(x, over.high);
  run.low += over.low;
  const DoubleDouble rest = rise / run;
  const double r = rest.high;
  const double square = r * r;
  const double less_r = r * square * (-1.0 / 3 + square * (1.0 / 5 - square * (1.0 / 7 - square * (1.0 / 9))));
  const DoubleDouble of_slope = kArcTangents[static_cast<std::size_t>(index)];
  const DoubleDouble sum = exact_sum(of_slope.high, r);
  const DoubleDouble angle = ordered_sum(sum.high, sum.low + (of_slope.low + rest.low + less_r));
  return steep ? kHalfPi - angle : angle;
}

// (asin(s) - s) / s^3 for s^2 from 0 to 1/4, by powers of s^2: a Chebyshev approximation, 2e-17 off at most.
constexpr std::array<double, 13> kArcSine{
    0x1.5555555555556p-3, 0x1.3333333332ecap-4,  0x1.6db6db6e31f13p-5, 0x1.f1c71c1db0616p-6, 0x1.6e8bb1c820b47p-6,
    0x1.1c4d35cf9336cp-6, 0x1.c9cf07677c4a3p-7,  0x1.782651c8d76bfp-7, 0x1.52420b0f60a10p-7, 0x1.65a9c48b9d3d2p-8,
    0x1.1d18943d47922p-6, -0x1.e6aaa93b7f6a2p-7, 0x1.d72b2bf9c56cdp-6};

/// asin(s) - s, for s from -1/2 to 1/2.
double arc_sine_beyond(double s, double square) {
  double series = kArcSine.back();
  for (std::size_t i = kArcSine.size() - 1; i-- > 0;) series = kArcSine[i] + square * series;
  return s * square * series;
}

}  // namespace

SinCos sin_cos(double angle_rad) {
  const double size = std::abs(angle_rad);
  if (size < kTiny) return {angle_rad, 1};
  if (size < kSmallRad) return {small_sine(angle_rad), small_cosine(angle_rad)};
  if (!std::isfinite(angle_rad)) return {angle_rad - angle_rad, angle_rad - angle_rad};
  const ReducedAngle angle = reduced(angle_rad);
  return {value(sine_of(angle, 0)), value(sine_of(angle, 1))};
}

double sin(double angle_rad) {
  const double size = std::abs(angle_rad);
  if (size < kTiny) return angle_rad;
  if (size < kSmallRad) return small_sine(angle_rad);
  return std::isfinite(angle_rad) ? value(sine_of(reduced(angle_rad), 0)) : angle_rad - angle_rad;
}

double cos(double angle_rad) {
  if (std::abs(angle_rad) < kSmallRad) return small_cosine(angle_rad);
  return std::isfinite(angle_rad) ? value(sine_of(reduced(angle_rad), 1)) : angle_rad - angle_rad;
}

double tan(double angle_rad) {
  if (!std::isfinite(angle_rad)) return angle_rad - angle_rad;
  if (std::abs(angle_rad) < kTiny) return angle_rad;
  const ReducedAngle angle = reduced(angle_rad);
  return value(sine_of(angle, 0) / sine_of(angle, 1));
}

double acos(double x) {
  if (!(std::abs(x) <= 1)) return std::numeric_limits<double>::quiet_NaN();
  if (std::abs(x) <= 0.5) {
    const DoubleDouble sum = exact_sum(kHalfPi.high, -x);
    return sum.high + (sum.low + (kHalfPi.low - arc_sine_beyond(x, x * x)));
  }
  // acos(x) = 2 asin(sqrt((1 - x) / 2))
  const double square = 0.5 * (1 - std::abs(x));
  const double root = std::sqrt(square);
  if (root == 0) return x > 0 ? 0 : kPi.high;
  const DoubleDouble back = exact_product(root, root);
  const double lost = ((square - back.high) - back.low) / (2 * root);
  const double beyond = lost + arc_sine_beyond(root, square);
  if (x > 0) return 2 * (root + beyond);
  const DoubleDouble sum = exact_sum(kPi.high, -2 * root);
  return sum.high + (sum.low + (kPi.low - 2 * beyond));
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return x + y;
  if (std::isinf(x) || std::isinf(y)) {
    y = std::copysign(std::isinf(y) ? 1 : 0, y);
    x = std::copysign(std::isinf(x) ? 1 : 0, x);
  }
  const bool back = std::signbit(x);
  if (y == 0) return std::copysign(back ? kPi.high : 0, y);
  double up = std::abs(y);
  double along = std::abs(x);
  if (along == 0) return std::copysign(kHalfPi.high, y);
  // The larger becomes a number from 2^-52 to 4, and the other one too large for it to lose digits that count.
  const std::uint64_t exponent =
      std::clamp<std::uint64_t>(std::bit_cast<std::uint64_t>(std::max(up, along)) >> 52, 1, 2045);
  const auto scale = std::bit_cast<double>((2046 - exponent) << 52);
  up *= scale;
  along *= scale;
  DoubleDouble angle;
  if (up < 0x1p-40 * along) {
    if (!back) return y / x;  // 2^-80 more than the angle
    angle = {up / along, 0};
  } else {
    angle = angle_of(up, along);
  }
  return std::copysign(value(back ? kPi - angle : angle), y);
}

}  // namespace poise::math
