// SPDX-License-Identifier: MIT
#include "ledger/unit_costs.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

namespace poise::ledger {
namespace {

using Functions = std::array<std::string_view, 4>;  // full names without arguments; none is inside another

/// The functions that begin each stage of a step. If a stage is renamed, split or added, only this table changes.
struct Stage {
  std::string_view name;
  Functions functions;
};

constexpr std::array kStages{
    Stage{"predict", {"poise::simulation::predict"}},
    Stage{"broad_phase", {"poise::simulation::find_candidates"}},
    Stage{"coarse", {"poise::simulation::find_active_pairs"}},
    Stage{"refine", {"poise::simulation::refine"}},
    Stage{"manifolds", {"poise::simulation::make_points_left", "poise::simulation::make_manifolds"}},
    Stage{"solve",
          {"poise::simulation::begin_solve", "poise::simulation::solve_impacts", "poise::simulation::solve_contacts",
           "poise::simulation::solve_swept"}},
    Stage{"integrate", {"poise::simulation::integrate"}},
    Stage{"publish", {"poise::simulation::publish"}},
    Stage{"sleep",
          {"poise::simulation::rest_after", "poise::simulation::wake_near_changes", "poise::simulation::wake_touched"}},
};

constexpr double kLeastShareOfStages = 0.95;
// Or what is in none is this little: where all sleep, a frame is hardly more than its clocks and its report.
constexpr double kMostBesideStages = 5000;

/// A unit of work: the instructions inside some functions, minus those inside others, and a count of the report.
struct Unit {
  std::string_view name;
  Functions functions;
  Functions less;
  double CountedUnits::*count;
  bool always = true;  // if there are such units, one of the functions is always called
};

constexpr Functions kOverlapTests{"poise::collision::N_AVX2::expand", "poise::collision::N_AVX2::expand_twice",
                                  "poise::collision::expand_plane_front"};

constexpr std::array kUnits{
    Unit{"expansion", kOverlapTests, {}, &CountedUnits::expansions},
    Unit{"level", {"poise::simulation::refine"}, kOverlapTests, &CountedUnits::levels},
    Unit{"contact_pair",
         {"poise::simulation::make_points_left", "poise::simulation::make_manifolds"},
         {},
         &CountedUnits::contact_pairs},
    Unit{"impact", {"poise::solver::solve_impacts"}, {}, &CountedUnits::contact_pairs, false},
    Unit{"point_iteration", {"poise::solver::ContactSolver::solve"}, {}, &CountedUnits::point_iterations},
    Unit{"body", {"poise::simulation::predict", "poise::simulation::integrate"}, {}, &CountedUnits::bodies},
    Unit{"candidate_pair",
         {"poise::simulation::find_candidates", "poise::simulation::find_active_pairs"},
         {},
         &CountedUnits::candidate_pairs},
};

/// With fewer units, the fixed cost of a frame dominates.
constexpr double kFewestUnits = 30;

double inside(const CallgrindProfile& profile, const Functions& functions) {
  std::uint64_t sum = 0;
  for (const std::string_view function : functions) {
    if (!function.empty()) sum += instructions_inside(profile, function);
  }
  return static_cast<double>(sum);
}

}  // namespace

Result<EntryCosts> unit_costs(const std::string& entry, const CallgrindProfile& profile, const CountedUnits& units) {
  EntryCosts costs;
  costs.entry = entry;
  const auto total = static_cast<double>(profile.total);
  costs.per_frame.push_back({"step", total / units.frames, units.frames});
  double in_stages = 0;
  for (const Stage& stage : kStages) {
    const double instructions = inside(profile, stage.functions);
    in_stages += instructions;
    if (instructions > 0)
      costs.per_frame.push_back({std::string(stage.name), instructions / units.frames, units.frames});
  }
  const bool too_few = in_stages < kLeastShareOfStages * total && total - in_stages > kMostBesideStages * units.frames;
  if (too_few || in_stages > total)
    return bad_input(
        fmt::format("{}: the stages make up {:.1f} % of the step, must be 95 to 100 %: a stage is missing or named "
                    "twice in bench/ledger/unit_costs.cpp",
                    entry, 100 * in_stages / total));
  for (const Unit& unit : kUnits) {
    const double count = units.*unit.count;
    if (count < kFewestUnits) continue;
    const double instructions = inside(profile, unit.functions) - inside(profile, unit.less);
    if (instructions <= 0 && !unit.always) continue;
    if (instructions <= 0)
      return bad_input(
          fmt::format("{}: {:.0f} units of {} and no function of them was called: mend the table in "
                      "bench/ledger/unit_costs.cpp",
                      entry, count, unit.name));
    costs.per_unit.push_back({std::string(unit.name), instructions / count, count});
  }
  return costs;
}

}  // namespace poise::ledger
