// SPDX-License-Identifier: MIT
#pragma once

#include <cfloat>

namespace poise::math {

// What follows holds where each operation is rounded once, to double: not on x87, and not with -ffast-math.
static_assert(FLT_EVAL_METHOD == 0, "poise needs arithmetic that rounds each operation to its own type");
#ifdef __FAST_MATH__
#error "poise is not to be compiled with -ffast-math: its results would depend on compiler and machine"
#endif

/// A number of about 106 bits: the sum of two doubles, the second at most half a unit in the last place of the first.
/// Only +, -, * and / of doubles make it up, so it has the same bits on every machine.
struct DoubleDouble {
  double high = 0;
  double low = 0;
};

/// a + b without error, where |a| >= |b| or a = 0 (Dekker 1971).
constexpr DoubleDouble ordered_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

/// a + b without error (Knuth 1969).
constexpr DoubleDouble exact_sum(double a, double b) {
  const double sum = a + b;
  const double of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}

/// a * b without error, where neither is above 2^996 and no product of halves is below 2^-1022 (Dekker, Veltkamp 1971).
/// A fused multiply-add would give the same bits, but is not on every machine.
constexpr DoubleDouble exact_product(double a, double b) {
  constexpr double kSplit = 134217729;  // 2^27 + 1
  const double wide_a = kSplit * a;
  const double top_a = wide_a - (wide_a - a);
  const double end_a = a - top_a;
  const double wide_b = kSplit * b;
  const double top_b = wide_b - (wide_b - b);
  const double end_b = b - top_b;
  const double product = a * b;
  return {product, ((top_a * top_b - product) + top_a * end_b + end_a * top_b) + end_a * end_b};
}

constexpr DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }

/// These lose at most a few units of 2^-104 of the result; a sum, of the larger term.
constexpr DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble high = exact_sum(a.high, b.high);
  return ordered_sum(high.high, high.low + (a.low + b.low));
}

constexpr DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + -b; }

constexpr DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble product = exact_product(a.high, b.high);
  return ordered_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

constexpr DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
  const double first = a.high / b.high;
  const DoubleDouble back = exact_product(first, b.high);
  return ordered_sum(first, (((a.high - back.high) - back.low) + (a.low - first * b.low)) / b.high);
}

}  // namespace poise::math
