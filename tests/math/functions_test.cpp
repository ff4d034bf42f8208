// SPDX-License-Identifier: MIT
#include "math/functions.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

namespace poise::math {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSmallest = std::numeric_limits<double>::denorm_min();

/// Numbers for the arguments: the same on every machine, so none of <random>'s distributions (splitmix64, Steele 2014).
class Draw {
 public:
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  double from_to(double low, double high) { return low + (high - low) * (static_cast<double>(bits() >> 11) * 0x1p-53); }
  /// Of any size from 2^low to 2^(high + 1), and a sign.
  double of_size(int low, int high) {
    const int exponent = low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1));
    const double sign = bits() % 2 == 0 ? 1 : -1;
    return sign * std::ldexp(from_to(1, 2), exponent);
  }

 private:
  std::uint64_t state_ = 1;
};

struct Argument {
  double x = 0;
  double y = 0;
};

struct Case {
  const char* name;
  std::function<double(Argument)> own;
  std::function<long double(Argument)> exact;  // to about 2^-63
  std::function<Argument(Draw&)> draw;
  double most_ulps = 0.5;
  std::uint64_t hash = 0;  // of the results
};

void PrintTo(const Case& of, std::ostream* out) { *out << of.name; }

using L = long double;

L wide(double x) { return static_cast<L>(x); }

Argument one(double x) { return {x, 0}; }

std::vector<Case> cases() {
  const auto angle = [](Draw& draw) { return one(draw.from_to(-7, 7)); };
  const auto small = [](Draw& draw) { return one(draw.from_to(-0.126, 0.126)); };
  const auto from_an_eighth = [](Draw& draw) {
    const double x = draw.from_to(0.125, 7);
    return one(draw.bits() % 2 == 0 ? x : -x);
  };
  const auto far_from_an_eighth = [](Draw& draw) { return one(draw.of_size(-3, 1000)); };
  const auto below_normal = [](Draw& draw) { return one(draw.from_to(-745.2, -708.4)); };
  const auto far = [](Draw& draw) { return one(draw.of_size(-30, 1000)); };
  const auto positive = [](Draw& draw) { return one(std::abs(draw.of_size(-1060, 1020))); };
  const auto near_1 = [](Draw& draw) { return one(draw.from_to(0.9, 1.1)); };
  const auto any = [](Draw& draw) { return one(draw.of_size(-1060, 1020)); };
  const auto sine = [](Argument a) { return math::sin(a.x); };
  const auto cosine = [](Argument a) { return math::cos(a.x); };
  const auto tangent = [](Argument a) { return math::tan(a.x); };
  const auto exact_sine = [](Argument a) { return sinl(wide(a.x)); };
  const auto exact_cosine = [](Argument a) { return cosl(wide(a.x)); };
  const auto exact_tangent = [](Argument a) { return tanl(wide(a.x)); };
  const auto logarithm = [](Argument a) { return math::log(a.x); };
  const auto logarithm_2 = [](Argument a) { return math::log2(a.x); };
  const auto exact_log = [](Argument a) { return logl(wide(a.x)); };
  const auto exact_log2 = [](Argument a) { return log2l(wide(a.x)); };
  const auto power = [](Argument a) { return math::pow(a.x, a.y); };
  const auto exact_power = [](Argument a) { return powl(wide(a.x), wide(a.y)); };
  return {
      {"sin", sine, exact_sine, angle, 0.51, 0x73288acc909ac20fULL},
      {"sin_small", sine, exact_sine, small, 0.51, 0xdf2c49ccd5f03960ULL},
      {"cos_small", cosine, exact_cosine, small, 0.51, 0x9ff49c0116962071ULL},
      {"sin_far", sine, exact_sine, far, 0.51, 0xbfb9800225b11034ULL},
      {"cos", cosine, exact_cosine, angle, 0.51, 0xe440cbb41b8446f3ULL},
      {"cos_far", cosine, exact_cosine, far, 0.51, 0xf5d70a2c14462957ULL},
      {"sin_from_an_eighth", sine, exact_sine, from_an_eighth, 0.501, 0x298c039efc63ac57ULL},
      {"cos_from_an_eighth", cosine, exact_cosine, from_an_eighth, 0.501, 0x0359b7f26c0f413dULL},
      {"sin_far_from_an_eighth", sine, exact_sine, far_from_an_eighth, 0.501, 0x31d80bcc1c7d61a3ULL},
      {"cos_far_from_an_eighth", cosine, exact_cosine, far_from_an_eighth, 0.501, 0xc3469321b2c74851ULL},
      {"sin_cos_sin", [](Argument a) { return sin_cos(a.x).sin; }, exact_sine, angle, 0.51, 0x73288acc909ac20fULL},
      {"sin_cos_cos", [](Argument a) { return sin_cos(a.x).cos; }, exact_cosine, angle, 0.51, 0xe440cbb41b8446f3ULL},
      {"tan", tangent, exact_tangent, angle, 0.501, 0x3c9d9dcbec70594eULL},
      {"tan_far", tangent, exact_tangent, far, 0.501, 0x881bcba1b026c26aULL},
      {"acos", [](Argument a) { return math::acos(a.x); }, [](Argument a) { return acosl(wide(a.x)); },
       [](Draw& draw) { return one(draw.from_to(-1, 1)); }, 0.65, 0x9574b82afd9d91bbULL},
      {"acos_near_1", [](Argument a) { return math::acos(a.x); }, [](Argument a) { return acosl(wide(a.x)); },
       [](Draw& draw) {
         const double off = draw.of_size(-50, -3);
         return one(off > 0 ? 1 - off : -1 - off);
       },
       0.65, 0xfc51c15a918463d0ULL},
      {"atan2", [](Argument a) { return math::atan2(a.y, a.x); },
       [](Argument a) { return atan2l(wide(a.y), wide(a.x)); },
       [](Draw& draw) {
         return Argument{draw.from_to(-1, 1), draw.from_to(-1, 1)};
       },
       0.501, 0xa7bad2fba9af7336ULL},
      {"atan2_far", [](Argument a) { return math::atan2(a.y, a.x); },
       [](Argument a) { return atan2l(wide(a.y), wide(a.x)); },
       [](Draw& draw) {
         return Argument{draw.of_size(-500, 500), draw.of_size(-500, 500)};
       },
       0.501, 0x4e9e3b0d327ca9acULL},
      {"exp", [](Argument a) { return math::exp(a.x); }, [](Argument a) { return expl(wide(a.x)); },
       [](Draw& draw) { return one(draw.from_to(-708, 709)); }, 0.501, 0x8140c8455e049d8dULL},
      {"exp_small", [](Argument a) { return math::exp(a.x); }, [](Argument a) { return expl(wide(a.x)); },
       [](Draw& draw) { return one(draw.of_size(-60, 1)); }, 0.501, 0x70df83a007a07912ULL},
      {"exp_below_normal", [](Argument a) { return math::exp(a.x); }, [](Argument a) { return expl(wide(a.x)); },
       below_normal, 1, 0x5602c6da909903c7ULL},
      {"log", logarithm, exact_log, positive, 0.501, 0x69b749c0e19badd4ULL},
      {"log_near_1", logarithm, exact_log, near_1, 0.501, 0x19dc50e26eadc12cULL},
      {"log2", logarithm_2, exact_log2, positive, 0.501, 0x423fcd31bcf78263ULL},
      {"log2_near_1", logarithm_2, exact_log2, near_1, 0.501, 0x49d9591e123fc025ULL},
      {"pow", power, exact_power,
       [](Draw& draw) {
         return Argument{draw.from_to(0, 8), draw.from_to(-8, 8)};
       },
       0.51, 0x3bb9b31475695917ULL},
      {"pow_far", power, exact_power,
       [](Draw& draw) {
         return Argument{std::abs(draw.of_size(-40, 40)), draw.from_to(-20, 20)};
       },
       0.51, 0xe41cdc8fb95a97abULL},
      {"pow_below_normal", power, exact_power,
       [](Draw& draw) {
         const double base = std::abs(draw.of_size(-40, -1));
         return Argument{base, draw.from_to(-1074.5, -1022.5) / math::log2(base)};
       },
       1, 0xd87bf1146c1f006bULL},
      {"cbrt", [](Argument a) { return math::cbrt(a.x); }, [](Argument a) { return cbrtl(wide(a.x)); }, any, 0.501,
       0x43ea2bdfaa532bbfULL},
  };
}

class Function : public testing::TestWithParam<Case> {};

/// Distance of two numbers in units in the last place of the double nearest to the exact one.
double ulps(double value, long double exact) {
  int exponent = -1074;
  if (static_cast<double>(exact) != 0) std::frexp(static_cast<double>(exact), &exponent);
  const L ulp = std::ldexp(L{1}, std::max(exponent - 53, -1074));
  return static_cast<double>(std::abs(wide(value) - exact) / ulp);
}

TEST_P(Function, IsNearlyTheExactValue) {
  if (std::numeric_limits<L>::digits < 64) GTEST_SKIP() << "long double is no wider than double here";
  const Case& of = GetParam();
  Draw draw;
  double most = 0;
  Argument where;
  for (int i = 0; i < 100'000; ++i) {
    const Argument at = of.draw(draw);
    const double off = ulps(of.own(at), of.exact(at));
    if (!(off <= most)) {
      most = off;
      where = at;
    }
  }
  constexpr double kOfTheReference = 0x1p-10;
  EXPECT_LE(most, of.most_ulps + kOfTheReference) << fmt::format("at {:a}, {:a}", where.x, where.y);
  fmt::print("{}: at most {:.4f} units in the last place\n", of.name, most);
}

TEST_P(Function, HasTheseBitsFromEveryCompilerOnEveryMachine) {
  const Case& of = GetParam();
  Draw draw;
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a, by eight bytes
  for (int i = 0; i < 20'000; ++i)
    hash = (hash ^ std::bit_cast<std::uint64_t>(of.own(of.draw(draw)))) * 0x100000001b3ULL;
  EXPECT_EQ(hash, of.hash) << fmt::format("{}: 0x{:016x}ULL", of.name, hash);
}

INSTANTIATE_TEST_SUITE_P(Of, Function, testing::ValuesIn(cases()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(SinCosTan, OfNumbersNextToMultiplesOfAQuarterTurnKeepTheirDigits) {
  // The double that is nearest to a multiple of pi/2 for its size (Muller, Elementary Functions, 1997).
  constexpr double kNearest = 0x1.6ac5b262ca1ffp+849;
  EXPECT_LE(ulps(math::cos(kNearest), cosl(wide(kNearest))), 0.501);
  EXPECT_EQ(math::sin(kNearest), 1);
  for (int i = 1; i < 4000; ++i) {
    const double x = i * 1.57079632679489661923;
    EXPECT_LE(ulps(math::sin(x), sinl(wide(x))), 0.502) << x;
    EXPECT_LE(ulps(math::cos(x), cosl(wide(x))), 0.502) << x;
  }
}

TEST(SinCosTan, AreSymmetricAndOneNearZero) {
  Draw draw;
  for (int i = 0; i < 10'000; ++i) {
    const double x = draw.of_size(-1060, 1020);
    EXPECT_EQ(math::sin(-x), -math::sin(x)) << x;
    EXPECT_EQ(math::cos(-x), math::cos(x)) << x;
    EXPECT_EQ(math::tan(-x), -math::tan(x)) << x;
    EXPECT_EQ(sin_cos(x).sin, math::sin(x)) << x;
    EXPECT_EQ(sin_cos(x).cos, math::cos(x)) << x;
  }
  EXPECT_TRUE(std::signbit(math::sin(-0.0)));
  EXPECT_EQ(math::sin(kSmallest), kSmallest);
  EXPECT_EQ(math::cos(kSmallest), 1);
  for (const double x : {kInfinity, -kInfinity, std::nan("")}) {
    EXPECT_TRUE(std::isnan(math::sin(x)) && std::isnan(math::cos(x)) && std::isnan(math::tan(x)));
    EXPECT_TRUE(std::isnan(sin_cos(x).sin) && std::isnan(sin_cos(x).cos));
  }
}

// IEEE 754-2019, 9.2.1, as std::atan2.
TEST(ArcTangent, OfZerosAndInfinitiesIsThatOfTheStandard) {
  for (const double y : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity, kSmallest, 1e308}) {
    for (const double x : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity, kSmallest, 1e308}) {
      const double own = math::atan2(y, x);
      EXPECT_EQ(own, static_cast<double>(atan2l(wide(y), wide(x)))) << y << ' ' << x;
      EXPECT_EQ(std::signbit(own), std::signbit(y)) << y << ' ' << x;
    }
  }
  EXPECT_TRUE(std::isnan(math::atan2(std::nan(""), 1)) && std::isnan(math::atan2(1, std::nan(""))));
}

TEST(ArcCosine, OfTheEndsIsExactAndBeyondThemIsNotANumber) {
  EXPECT_EQ(math::acos(1), 0);
  EXPECT_EQ(math::acos(-1), 3.14159265358979323846);
  EXPECT_EQ(math::acos(0), 1.57079632679489661923);
  EXPECT_TRUE(std::isnan(math::acos(1 + 0x1p-52)) && std::isnan(math::acos(-kInfinity)) &&
              std::isnan(math::acos(std::nan(""))));
}

TEST(Exponential, EndsWhereDoublesEnd) {
  EXPECT_EQ(math::exp(0), 1);
  EXPECT_EQ(math::exp(-0.0), 1);
  EXPECT_EQ(math::exp(kInfinity), kInfinity);
  EXPECT_EQ(math::exp(-kInfinity), 0);
  EXPECT_EQ(math::exp(710), kInfinity);
  EXPECT_EQ(math::exp(-746), 0);
  EXPECT_TRUE(std::isfinite(math::exp(709.78)));
  EXPECT_EQ(math::exp(-745), kSmallest);
  EXPECT_TRUE(std::isnan(math::exp(std::nan(""))));
}

TEST(Logarithm, OfPowersOfTwoIsExactAndOfNoPositiveNumberIsRefused) {
  for (int k = -1074; k < 1024; ++k) EXPECT_EQ(math::log2(std::ldexp(1.0, k)), k);
  EXPECT_EQ(math::log(1), 0);
  for (const auto& log : {math::log, math::log2}) {
    EXPECT_EQ(log(0), -kInfinity);
    EXPECT_EQ(log(kInfinity), kInfinity);
    EXPECT_TRUE(std::isnan(log(-1)) && std::isnan(log(std::nan(""))));
  }
}

TEST(Power, OfSimpleExponentsIsExact) {
  Draw draw;
  for (int i = 0; i < 10'000; ++i) {
    const double x = std::abs(draw.of_size(-300, 300));
    EXPECT_EQ(math::pow(x, 1), x);
    EXPECT_EQ(math::pow(x, 0), 1);
    EXPECT_EQ(math::pow(1, x), 1);
    const double small = static_cast<double>(draw.bits() % 1000);
    EXPECT_EQ(math::pow(small, 3), small * small * small);
  }
  EXPECT_EQ(math::pow(0, 2), 0);
  EXPECT_EQ(math::pow(0, -2), kInfinity);
  EXPECT_EQ(math::pow(2, kInfinity), kInfinity);
  EXPECT_EQ(math::pow(0.5, kInfinity), 0);
  EXPECT_EQ(math::pow(0, 0.01), 0);
  EXPECT_EQ(math::pow(0, -0.01), kInfinity);
  // Beyond what can be split in two.
  EXPECT_EQ(math::pow(2, 1.7e308), kInfinity);
  EXPECT_EQ(math::pow(0.5, 1.7e308), 0);
  EXPECT_EQ(math::pow(2, 1e300), kInfinity);
  EXPECT_EQ(math::pow(2, -1e300), 0);
  EXPECT_EQ(math::pow(kInfinity, -1), 0);
  EXPECT_EQ(math::pow(2, -1074), kSmallest);
  EXPECT_TRUE(std::isnan(math::pow(-2, 2)) && std::isnan(math::pow(2, std::nan(""))));
}

TEST(CubeRoot, OfCubesIsExact) {
  for (int i = -1000; i <= 1000; ++i) EXPECT_EQ(math::cbrt(static_cast<double>(i) * i * i), i);
  EXPECT_EQ(math::cbrt(0x1p-1074), 0x1p-358);
  EXPECT_EQ(math::cbrt(-kInfinity), -kInfinity);
  EXPECT_TRUE(std::signbit(math::cbrt(-0.0)));
}

}  // namespace
}  // namespace poise::math
