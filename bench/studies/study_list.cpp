// SPDX-License-Identifier: MIT
#include "studies/study_list.h"

#include <memory>

#include "studies/study_accuracy.h"
#include "studies/study_compliance.h"
#include "studies/study_forecast.h"
#include "studies/study_levels.h"
#include "studies/study_overload.h"
#include "studies/study_population.h"
#include "studies/study_timing.h"
#include "studies/study_trees.h"

namespace poise::app {

void add_studies(CLI::App& command, int& exit_code) {
  auto trees = std::make_shared<StudyTreesOptions>();
  CLI::App* study =
      command.add_subcommand("trees", "Build and measure the trees of many meshes: cost and fit, a row a mesh");
  add_study_trees_options(*study, *trees);
  study->callback([trees, &exit_code] { exit_code = study_trees(*trees); });
  auto levels = std::make_shared<StudyLevelsOptions>();
  CLI::App* levels_study =
      command.add_subcommand("levels", "Compare the answers of each level and contact model with the exact ones");
  add_study_levels_options(*levels_study, *levels);
  levels_study->callback([levels, &exit_code] { exit_code = study_levels(*levels); });
  auto accuracy = std::make_shared<StudyAccuracyOptions>();
  CLI::App* accuracy_study = command.add_subcommand("accuracy", "Run cases whose outcome is known, and compare");
  add_study_accuracy_options(*accuracy_study, *accuracy);
  auto cost = std::make_shared<StudyTimingOptions>();
  CLI::App* cost_study = command.add_subcommand(
      "cost", "Time each mandatory stage: nanoseconds a candidate pair and a body, falling and settled");
  add_study_cost_options(*cost_study, *cost);
  cost_study->callback([cost, &exit_code] { exit_code = study_cost(*cost); });
  auto cache = std::make_shared<StudyTimingOptions>();
  CLI::App* cache_study =
      command.add_subcommand("cache", "Compare frames that use the contact cache with frames that start without it");
  add_study_cache_options(*cache_study, *cache);
  cache_study->callback([cache, &exit_code] { exit_code = study_cache(*cache); });
  auto scaling = std::make_shared<StudyTimingOptions>();
  CLI::App* scaling_study = command.add_subcommand("scaling", "Time refinement on several numbers of threads");
  add_study_scaling_options(*scaling_study, *scaling);
  scaling_study->callback([scaling, &exit_code] { exit_code = study_scaling(*scaling); });
  auto free = std::make_shared<StudyTimingOptions>();
  CLI::App* free_study =
      command.add_subcommand("free", "Count the instructions of a step with each feature off and on (needs valgrind)");
  add_study_free_options(*free_study, *free);
  free_study->callback([free, &exit_code] { exit_code = study_free(*free); });
  accuracy_study->callback([accuracy, &exit_code] { exit_code = study_accuracy(*accuracy); });
  auto compliance = std::make_shared<StudyComplianceOptions>();
  CLI::App* compliance_study =
      command.add_subcommand("compliance", "Are deadlines kept as often as asked, whatever the population?");
  add_study_compliance_options(*compliance_study, *compliance);
  compliance_study->callback([compliance, &exit_code] { exit_code = study_compliance(*compliance); });
  auto forecast = std::make_shared<StudyForecastOptions>();
  CLI::App* forecast_study =
      command.add_subcommand("forecast", "Compare ways to reserve time for the end of a frame, on recorded frames");
  add_study_forecast_options(*forecast_study, *forecast);
  forecast_study->callback([forecast, &exit_code] { exit_code = study_forecast(*forecast); });
  auto constant = std::make_shared<StudyConstantTimeOptions>();
  CLI::App* constant_study = command.add_subcommand(
      "constant-time", "Time of a frame against the number of bodies, with and without a deadline");
  add_study_constant_time_options(*constant_study, *constant);
  constant_study->callback([constant, &exit_code] { exit_code = study_constant_time(*constant); });
  auto overload = std::make_shared<StudyOverloadOptions>();
  CLI::App* overload_study =
      command.add_subcommand("overload", "Does a scene get out of overload again? Demand goes up and comes back");
  add_study_overload_options(*overload_study, *overload);
  overload_study->callback([overload, &exit_code] { exit_code = study_overload(*overload); });
  auto population = std::make_shared<StudyPopulationOptions>();
  CLI::App* population_study =
      command.add_subcommand("population", "Late frames, levels, error and memory of a scene as its population grows");
  add_study_population_options(*population_study, *population);
  population_study->callback([population, &exit_code] { exit_code = study_population(*population); });
}

}  // namespace poise::app
