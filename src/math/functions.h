// SPDX-License-Identifier: MIT
#pragma once

/// The functions of <cmath> that the state of a world may depend on, with the same bits on every machine and from every
/// compiler. Those of C libraries differ from one to another, and glibc's differ with the processor. These are made of
/// +, -, *, / and square roots of doubles, and of comparisons. What IEEE 754 defines to the bit (std::sqrt, abs, floor,
/// fmod, ...) stays that of the standard library. The rule is checked by tests/architecture.
///
/// Every result differs from the exact value by less than 0.501 units in the last place (sin and cos below 1/8 rad, and
/// pow: 0.51; acos: 0.65; where a result is below 2^-1022: 1), so it is nearly always the double nearest to it. Any
/// thread; nothing is allocated.
namespace poise::math {

struct SinCos {
  double sin = 0;
  double cos = 0;
};

/// Of an angle in rad. NaN for an infinite angle.
double sin(double angle_rad);
double cos(double angle_rad);
double tan(double angle_rad);
/// Both, in little more time than one.
SinCos sin_cos(double angle_rad);

/// From 0 to pi; NaN where |x| > 1.
double acos(double x);
/// The angle of (x, y) from the x axis, from -pi to pi, with the signs of zeros as in std::atan2.
double atan2(double y, double x);

double exp(double x);
/// -infinity of 0, NaN of a negative x.
double log(double x);
double log2(double x);
/// Of a base of at least 0; NaN for a negative base. pow(x, 0) = 1 and pow(1, y) = 1.
double pow(double base, double exponent);
/// The cube root, of a negative x too.
double cbrt(double x);

}  // namespace poise::math
