// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>

/// Another C library: each of its functions that is not exact by IEEE 754 is off by a unit in the last place. A program
/// that defines these calls them everywhere, so whatever has the same hash in it does not depend on them. (That of
/// glibc has several variants itself, and takes one by the processor.)
namespace {

template <class Number, class Bits>
Number off(Number value) {
  if (!std::isfinite(value) || value == 0) return value;
  return std::bit_cast<Number>(std::bit_cast<Bits>(value) + 1);
}

double of(long double value) { return off<double, std::uint64_t>(static_cast<double>(value)); }
long double wide(double x) { return static_cast<long double>(x); }
long double wide(float x) { return static_cast<long double>(x); }
float of_float(long double value) { return off<float, std::uint32_t>(static_cast<float>(value)); }

}  // namespace

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming,cert-dcl58-cpp)
extern "C" {
#define POISE_OTHER(name)                                         \
  double name(double x) noexcept { return of(name##l(wide(x))); } \
  float name##f(float x) noexcept { return of_float(name##l(wide(x))); }
#define POISE_OTHER_2(name)                                                          \
  double name(double x, double y) noexcept { return of(name##l(wide(x), wide(y))); } \
  float name##f(float x, float y) noexcept { return of_float(name##l(wide(x), wide(y))); }
POISE_OTHER(sin)
POISE_OTHER(cos)
POISE_OTHER(tan)
POISE_OTHER(asin)
POISE_OTHER(acos)
POISE_OTHER(atan)
POISE_OTHER(sinh)
POISE_OTHER(cosh)
POISE_OTHER(tanh)
POISE_OTHER(exp)
POISE_OTHER(exp2)
POISE_OTHER(expm1)
POISE_OTHER(log)
POISE_OTHER(log2)
POISE_OTHER(log10)
POISE_OTHER(log1p)
POISE_OTHER(exp10)
POISE_OTHER(cbrt)
POISE_OTHER(asinh)
POISE_OTHER(acosh)
POISE_OTHER(atanh)
POISE_OTHER(erf)
POISE_OTHER(erfc)
POISE_OTHER(lgamma)
POISE_OTHER(tgamma)
POISE_OTHER_2(atan2)
POISE_OTHER_2(pow)
POISE_OTHER_2(hypot)
#undef POISE_OTHER
#undef POISE_OTHER_2
// What compilers call in place of a sine and a cosine.
void sincos(double x, double* sine, double* cosine) noexcept {
  *sine = of(sinl(wide(x)));
  *cosine = of(cosl(wide(x)));
}
void sincosf(float x, float* sine, float* cosine) noexcept {
  *sine = of_float(sinl(wide(x)));
  *cosine = of_float(cosl(wide(x)));
}
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming,cert-dcl58-cpp)

namespace poise {
namespace {

TEST(OtherLibm, IsTheOneThatThisProgramCalls) {
  volatile double x = 0.5;  // not known to the compiler, which would compute the rest itself
  EXPECT_NE(std::sin(x), static_cast<double>(sinl(wide(x))));
  EXPECT_NE(std::cos(x), static_cast<double>(cosl(wide(x))));
  EXPECT_NE(std::atan2(x, 2.0), static_cast<double>(atan2l(wide(x), 2.0L)));
  EXPECT_NE(std::pow(x, 0.3), static_cast<double>(powl(wide(x), wide(0.3))));
  EXPECT_NE(std::log(x), static_cast<double>(logl(wide(x))));
  EXPECT_NE(std::asinh(x), static_cast<double>(asinhl(wide(x))));
  EXPECT_NE(std::tgamma(x), static_cast<double>(tgammal(wide(x))));
}

}  // namespace
}  // namespace poise
