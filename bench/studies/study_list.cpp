// SPDX-License-Identifier: MIT
#include "studies/study_list.h"

#include <cstdint>
#include <memory>
#include <vector>

#include "studies/study_accuracy.h"
#include "studies/study_compliance.h"
#include "studies/study_crowd.h"
#include "studies/study_draw.h"
#include "studies/study_error_time.h"
#include "studies/study_forecast.h"
#include "studies/study_gaze.h"
#include "studies/study_levels.h"
#include "studies/study_order.h"
#include "studies/study_overload.h"
#include "studies/study_population.h"
#include "studies/study_report.h"
#include "studies/study_rest.h"
#include "studies/study_strips.h"
#include "studies/study_timing.h"
#include "studies/study_trees.h"

namespace poise::app {
namespace {

/// What the page of a study shows besides charts.
enum class StudyPicture : std::uint8_t { None, Own, ByGnuplot };

/// Where the options of a study name what it writes.
template <class Options>
StudyFiles files_of(Options& options, StudyPicture picture) {
  if constexpr (requires { options.common; }) {
    return files_of(options.common, picture);
  } else {
    StudyFiles files{&options.json, &options.markdown};
    files.quiet = &options.quiet;
    if constexpr (requires { options.picture; }) {
      if (picture != StudyPicture::None) {
        files.picture = &options.picture.png;
        files.svg = &options.picture.svg;
        files.picture_needs_gnuplot = picture == StudyPicture::ByGnuplot;
      }
    }
    return files;
  }
}

template <class Options>
void give_charts(Options& options, std::vector<LineChart>& charts) {
  if constexpr (requires { options.common; }) {
    options.common.page_charts = &charts;
  } else {
    options.page_charts = &charts;
  }
}

template <class Options>
void add_study(CLI::App& command, const char* name, const char* description, void (*declare)(CLI::App&, Options&),
               int (*run)(const Options&), int& exit_code, StudyPicture picture = StudyPicture::None) {
  auto options = std::make_shared<Options>();
  auto report = std::make_shared<StudyReport>();
  report->study = name;
  report->description = description;
  give_charts(*options, report->charts);
  CLI::App* study = command.add_subcommand(name, description);
  declare(*study, *options);
  add_study_report(*study, *report);
  study->callback([options, report, run, picture, &exit_code] {
    exit_code = with_study_report(*report, files_of(*options, picture), [&] { return run(*options); });
  });
}

}  // namespace

void add_studies(CLI::App& command, int& exit_code) {
  add_study(command, "trees", "Build and measure the trees of many meshes: cost and fit, a row a mesh",
            add_study_trees_options, study_trees, exit_code);
  add_study(command, "levels", "Compare the answers of each level and contact model with the exact ones",
            add_study_levels_options, study_levels, exit_code);
  add_study(command, "accuracy", "Run cases whose outcome is known, and compare", add_study_accuracy_options,
            study_accuracy, exit_code);
  add_study(command, "rest", "Which meshes come to rest on a plane, at each level and by polygons",
            add_study_rest_options, study_rest, exit_code);
  add_study(command, "cost", "Time each mandatory stage: nanoseconds a candidate pair and a body, falling and settled",
            add_study_cost_options, study_cost, exit_code);
  add_study(command, "cache", "Compare frames that use the contact cache with frames that start without it",
            add_study_cache_options, study_cache, exit_code);
  add_study(command, "scaling", "Time refinement on several numbers of threads", add_study_scaling_options,
            study_scaling, exit_code);
  add_study(command, "free", "Count the instructions of a step with each feature off and on (needs valgrind)",
            add_study_free_options, study_free, exit_code);
  add_study(command, "compliance", "Are deadlines kept as often as asked, whatever the population?",
            add_study_compliance_options, study_compliance, exit_code);
  add_study(command, "forecast", "Compare ways to reserve time for the end of a frame, on recorded frames",
            add_study_forecast_options, study_forecast, exit_code);
  add_study(command, "constant-time", "Time of a frame against the number of bodies, with and without a deadline",
            add_study_constant_time_options, study_constant_time, exit_code);
  add_study(command, "overload", "Does a scene get out of overload again? Demand goes up and comes back",
            add_study_overload_options, study_overload, exit_code);
  add_study(command, "order", "What ranking pairs takes, and how far their order is from a sorted one",
            add_study_order_options, study_order, exit_code);
  add_study(command, "crowd", "How far steps of a crowd are from their references: by contacts, by the response",
            add_study_crowd_options, study_crowd, exit_code);
  add_study(command, "error-time", "Error of a step against its time: deadlines, levels and other engines",
            add_study_error_time_options, study_error_time, exit_code);
  add_study(command, "gaze", "Error near the gaze and elsewhere, and frames until a jump of the gaze is served",
            add_study_gaze_options, study_gaze, exit_code, StudyPicture::ByGnuplot);
  add_study(command, "population", "Late frames, levels, error and memory of a scene as its population grows",
            add_study_population_options, study_population, exit_code);
  add_study(command, "strips", "One collision of two bodies, interrupted at each level: gaps and velocities",
            add_study_strips_options, study_strips, exit_code, StudyPicture::Own);
  auto drawn = std::make_shared<StudyDrawOptions>();
  CLI::App* draw = command.add_subcommand("draw", "Draw the charts of a study again, from its JSON");
  add_study_draw_options(*draw, *drawn);
  draw->callback([drawn, &exit_code] { exit_code = study_draw(*drawn); });
}

}  // namespace poise::app
