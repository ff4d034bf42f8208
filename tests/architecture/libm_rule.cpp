// SPDX-License-Identifier: MIT
#include "architecture/libm_rule.h"

#include <algorithm>
#include <array>
#include <regex>

namespace poise::tests {
namespace {

// These look at the state, or draw and measure; nothing that they compute goes back.
constexpr std::array<std::string_view, 4> kRoomsThatLook{"capture", "app", "bench", "examples"};

constexpr std::array kOutsideTheState{
    OutsideTheState{"src/scene/check/placed_bodies.cpp", "estimates of `poise check`"},
    OutsideTheState{"src/scene/check/scene_check.cpp", "estimates of `poise check`"},
    OutsideTheState{"src/scene/compare/comparison_plot.cpp", "the steps of an axis"},
    OutsideTheState{"src/scene/run/run_statistics.cpp", "intervals of confidence in reports"},
    OutsideTheState{"src/verify/reference_figures.cpp", "figures of errors in reports"},
};

// A part of everything that the rule finds: most lines have none, and regular expressions take their time.
constexpr std::array<std::string_view, 33> kParts{
    "polar", "ellint",     "bessel",        "Random",   "rand",          "shuffle",   "sample",     "Approximate",
    "sqrt_",

    "sin",   "cos",        "tan",           "exp",      "log",           "pow",       "cbrt",       "hypot",
    "erf",   "gamma",      "beta",          "legendre", "zeta",          "AngleAxis", "Rotation2D", "angularDistance",
    "slerp", "ulerAngles", "computeDirect", "Norm",     "_distribution", "std::g",    "std::s",     "std::h"};

}  // namespace

std::optional<std::string> depends_on_libm(std::string_view room, std::string_view path, std::string_view code) {
  if (std::ranges::find(kRoomsThatLook, room) != kRoomsThatLook.end()) return std::nullopt;
  if (std::ranges::any_of(kOutsideTheState, [&](const OutsideTheState& file) { return file.path == path; }))
    return std::nullopt;
  const auto in_code = [&](std::string_view part) { return code.find(part) != std::string_view::npos; };
  if (std::ranges::none_of(kParts, in_code)) return std::nullopt;
  // sqrt, abs, floor, ceil, trunc, round, fmod, frexp, ldexp, fma and the like are exact by IEEE 754.
  static const std::string names =
      "(sincos|a?(sin|cos|tan)h?|atan2|exp2?|expm1|log(2|10|1p)?|pow|cbrt|hypot|erfc?|[lt]gamma|beta|legendre|"
      "riemann_zeta|polar|exp10|expint|cyl_\\w+|sph_(bessel|legendre|neumann)\\w*|(comp_)?ellint_\\w+)[fl]?";
  // Where they are named, called or not.
  static const std::regex of_library(R"(\b(std|numext)::)" + names + R"(\b|(^|[^\w:.>])(::|__builtin_))" + names +
                                     R"(\s*\()");
  static const std::regex bare("(^|[^\\w:.>])" + names + R"(\s*\()");
  static const std::regex of_eigen(
      R"((\.|->)()" + names +
      R"()\s*\(|\b(AngleAxis|AngleAxis[df]|Rotation2D[df]?|angularDistance|slerp|eulerAngles|canonicalEulerAngles|)"
      R"(computeDirect|stableNorm|blueNorm|hypotNorm)\b)");
  static const std::regex drawn(
      R"(\bstd::\w+_distribution\b|\bstd::(generate_canonical|hash|(ranges::)?(shuffle|sample))\b|)"
      R"(::Random\s*\(|\b(setRandom|UnitRandom|s?rand)\s*\()");
  // Of processors: each has its own bits.
  static const std::regex approximate(R"(\bApproximate\w+|\b_mm\d*_(mask_)?r(sqrt|cp)\w*)");
  const auto found = [&](const std::regex& pattern) { return std::regex_search(code.begin(), code.end(), pattern); };
  // Declarations of these functions in src/math look like calls.
  const bool calls = found(of_library) || (room != "math" && found(bare));
  if (calls || found(of_eigen)) return "differs between C libraries and processors: src/math has the like";
  if (found(drawn)) return "differs between standard libraries";
  if (found(approximate)) return "differs between processors";
  return std::nullopt;
}

}  // namespace poise::tests
