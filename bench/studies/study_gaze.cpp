// SPDX-License-Identifier: MIT
#include "studies/study_gaze.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "scene/policy_file.h"

namespace poise::app {
namespace {

constexpr const char* kGazeScene = "jacks";
constexpr std::uint64_t kBodies = 2000;
constexpr std::uint64_t kSettle = 300;
constexpr std::uint64_t kSeeds = 3;
constexpr std::uint64_t kStates = 10;
constexpr std::uint64_t kStateEvery = 12;
constexpr std::uint64_t kJumps = 8;
constexpr std::uint64_t kHold = 30;
constexpr std::uint64_t kLeastHold = 20;
constexpr double kBudgetPercent = 25;
// A heap that is shaken less is known from the frames before: at 0.5 m/s a quarter of the work leaves 1 % of its levels
// undone, and the solver's own error is all that is seen. Chosen.
constexpr double kShake_mps = 4;
constexpr std::array<int, 7> kShownFrames{-1, 0, 1, 2, 3, 5, 10};

io::StudyCell cell(const std::optional<double>& value) { return value ? io::StudyCell(*value) : io::StudyCell(); }
io::StudyCell cell(const std::optional<std::uint64_t>& value) {
  return value ? io::StudyCell(*value) : io::StudyCell(std::string("never"));
}

Result<scheduler::Policy> policy_of(const StudyGazeOptions& o, const Scene& scene) {
  scheduler::Policy policy = scene.policy;
  for (const std::string& weight : o.weights) {
    const Status set = io::set_weight(weight, policy);
    if (!set) return bad_input("--weight: " + set.error().message);
  }
  return policy;
}

GazeSettings settings_of(const StudyGazeOptions& o, const scheduler::Policy& policy) {
  GazeSettings settings;
  settings.bodies = o.bodies.value_or(kBodies);
  settings.settle = o.settle.value_or(kSettle);
  settings.seeds = o.seeds.value_or(kSeeds);
  settings.states = o.states.value_or(kStates);
  settings.every = o.every.value_or(kStateEvery);
  settings.jumps = o.jumps.value_or(kJumps);
  settings.hold = o.hold.value_or(kHold);
  settings.budget_share = 0.01 * o.budget_percent.value_or(kBudgetPercent);
  settings.shake.speed_mps = o.shake_mps.value_or(kShake_mps);
  settings.policy = policy;
  return settings;
}

std::string bin_name(std::size_t bin) {
  if (bin == kBinEnds_deg.size()) return fmt::format("> {:g}", kBinEnds_deg.back());
  return fmt::format("{:g} to {:g}", bin == 0 ? 0.0 : kBinEnds_deg[bin - 1], kBinEnds_deg[bin]);
}

void add_bins(const GazeRun& run, io::StudyTable& table) {
  table.columns = {{"gaze", "gaze", 0},
                   {"eccentricity_deg", "degrees from it", 0},
                   {"bodies", "bodies", 0},
                   {"e_mps", "E m/s", 4},
                   {"elsewhere_mps", "E, gaze elsewhere", 4},
                   {"full_e_mps", "E, all refined", 4},
                   {"contacts", "contacts", 0},
                   {"level_mean", "level", 3},
                   {"answered_share", "answered pairs (share)", 3}};
  for (const GazeBinRow& row : gaze_bins(run.states)) {
    table.rows.push_back({std::string(kGazeNames[row.gaze_point]), bin_name(row.bin), row.bodies, cell(row.e_mps),
                          cell(row.elsewhere_mps), cell(row.full_e_mps), row.levels.contacts,
                          cell(row.levels.level_mean()), cell(row.levels.answered_share())});
  }
}

void add_near(const GazeRun& run, std::uint64_t seed, io::StudyTable& table) {
  table.summary = io::StudySummary{"near",
                                   {{"gaze", fmt::format("within {:g} degrees of the gaze", kNear_deg), 0},
                                    {"bodies", "bodies", 0},
                                    {"e_mps", "E m/s", 4},
                                    {"elsewhere_mps", "E, gaze elsewhere", 4},
                                    {"full_e_mps", "E, all refined", 4},
                                    {"ratio", "E / elsewhere", 3},
                                    {"ratio_low", "95 % from", 3},
                                    {"ratio_high", "to", 3}},
                                   {}};
  for (const NearRatio& near : near_ratios(run.states, seed)) {
    table.summary->rows.push_back({std::string(near.gaze_point ? kGazeNames[*near.gaze_point] : "all three"),
                                   near.bodies, cell(near.e_mps), cell(near.elsewhere_mps), cell(near.full_e_mps),
                                   cell(near.ratio), near.ratio ? io::StudyCell(near.low) : io::StudyCell(),
                                   near.ratio ? io::StudyCell(near.high) : io::StudyCell()});
  }
}

// A row a frame: of the shown ones with titles, of all of them for JSON.
io::StudySummary jump_frames(const GazeRun& run, bool shown) {
  io::StudySummary part{shown ? "after_jump" : "jump_frames",
                        {{"frame", "frame after the jump", 0},
                         {"level_new", "level near the new point", 3},
                         {"answered_new", "answered there", 3},
                         {"level_old", "level near the old one", 3},
                         {"answered_old", "answered there", 3}},
                        {}};
  std::vector<std::vector<double>> curves;
  for (const auto where : {&GazeJump::at_new, &GazeJump::at_old}) {
    for (const PairFigure figure : {&PairLevels::level_mean, &PairLevels::answered_share})
      curves.push_back(mean_over_jumps(run.jumps, where, figure));
  }
  const auto half = static_cast<int>(curves[0].size() / 2);
  for (int frame = -half; frame < half; ++frame) {
    if (shown && std::ranges::find(kShownFrames, frame) == kShownFrames.end()) continue;
    std::vector<io::StudyCell>& row = part.rows.emplace_back();
    row.emplace_back(fmt::format("{}", frame));
    const int place = frame + half;
    for (const std::vector<double>& curve : curves) row.emplace_back(curve[static_cast<std::size_t>(place)]);
  }
  if (shown) return part;
  for (io::StudyColumn& column : part.columns) column.title.clear();
  return part;
}

io::StudySummary served(const GazeRun& run) {
  io::StudySummary part{"served",
                        {{"figure", "served by", 0},
                         {"before", "before", 3},
                         {"settled", "settled", 3},
                         {"mean_served", "mean served in frame", 0},
                         {"jumps", "jumps", 0},
                         {"median", "each served in frame: median", 0},
                         {"largest", "largest", 0},
                         {"within_three", "of them by frame 3", 0},
                         {"without_rise", "jumps without a rise", 0}},
                        {}};
  for (const auto& [name, figure] : {std::pair<const char*, PairFigure>{"level", &PairLevels::level_mean},
                                     {"answered pairs", &PairLevels::answered_share}}) {
    const ServedFigures f = served_figures(run.jumps, figure);
    part.rows.push_back({std::string(name), f.before, f.settled, cell(f.of_mean), f.jumps, cell(f.median),
                         cell(f.largest), f.within_three, f.without_rise});
  }
  return part;
}

io::StudySummary cells(const GazeRun& run) {
  io::StudySummary part{"cells", {{"gaze", "", 0}, {"column", "", 0}, {"row", "", 0}, {"e_mps", "", 4}}, {}};
  for (std::size_t point = 0; point < kGazePoints; ++point) {
    const std::vector<std::optional<double>> of_point = gaze_cells(run.states, point);
    for (std::size_t i = 0; i < of_point.size(); ++i) {
      part.rows.push_back({std::string(kGazeNames[point]), std::uint64_t{i % kCellsAcross},
                           std::uint64_t{i / kCellsAcross}, cell(of_point[i])});
    }
  }
  return part;
}

// Work of full refinement of a state: more than in a run without a limit, since more is left undone.
double mean_full_units(const GazeRun& run) {
  double sum = 0;
  for (const GazeState& state : run.states) sum += state.full_units / static_cast<double>(run.states.size());
  return sum;
}

// Ctrl-C is caught here alone: gnuplot catches it for itself.
Result<GazeRun> measured(const StudyGazeOptions& o, const StudyScene& scene, const GazeSettings& settings) {
  Progress progress(!o.common.quiet);
  const parallel::Interrupt interrupt;
  progress.say("gaze");
  Result<GazeRun> run = run_gaze(
      scene.scene(), scene.start_options(), settings, [&](double share) { progress.share("gaze", share); }, &interrupt);
  progress.end();
  return run;
}

}  // namespace

void add_study_gaze_options(CLI::App& command, StudyGazeOptions& o) {
  add_whole(command, "--bodies", o.bodies, 1, kMaxSceneBodies / 100, fmt::format("Bodies (default {})", kBodies));
  add_whole(command, "--settle", o.settle, 1, kMaxSceneFrames,
            fmt::format("Frames before the first state (default {})", kSettle));
  add_whole(command, "--seeds", o.seeds, 1, 1000, fmt::format("Runs, each of another seed (default {})", kSeeds));
  add_whole(command, "--states", o.states, 1, 10'000, fmt::format("States of each run (default {})", kStates));
  add_whole(command, "--every", o.every, 1, 10'000,
            fmt::format("Frames from one state to the next (default {})", kStateEvery));
  add_whole(command, "--jumps", o.jumps, 0, 10'000, fmt::format("Jumps of the gaze in each run (default {})", kJumps));
  add_whole(command, "--hold", o.hold, kLeastHold, 10'000,
            fmt::format("Frames from one jump to the next (default {})", kHold));
  add_number(command, "--budget", o.budget_percent, 0, true, 100,
             fmt::format("Work of a frame in % of full refinement (default {:g})", kBudgetPercent));
  add_number(
      command, "--shake", o.shake_mps, 0, false, 1000,
      fmt::format("Change the velocity of each body by this many m/s once in 16 frames (default {:g})", kShake_mps));
  command.add_option("--weight", o.weights, "Exponent of a cue, as eccentricity=0; may be given several times")
      ->type_name("CUE=VALUE");
  add_study_outputs(command, o.common, kGazeScene);
  command.footer(
      "Examples:\n"
      "  poise study gaze --markdown gaze.md --picture gaze.png\n"
      "  poise study gaze --bodies 500 --states 4 --weight eccentricity=0      the gaze changes nothing: the ratio is "
      "1\n\n"
      "A heap is shaken in front of a camera that it fills. States of it are stepped with the gaze at the left, in "
      "the\n"
      "middle and at the right of the picture, and held against one reference a state: the error of what is near the\n"
      "gaze, and of the same bodies with the gaze elsewhere. Then the gaze jumps from left to right and back, in a "
      "run\n"
      "with a budget: how many frames until the new place is served. Budgets are counted work, so the figures are the\n"
      "same on any machine. Words and figures: docs/priorities.md.");
}

void add_gaze_tables(const GazeRun& run, std::uint64_t seed, io::StudyTable& table) {
  add_bins(run, table);
  add_near(run, seed, table);
  if (!run.jumps.empty()) {
    table.more.push_back(jump_frames(run, true));
    table.more.push_back(served(run));
    table.more.push_back(jump_frames(run, false));
  }
  table.more.push_back(cells(run));
}

int study_gaze(const StudyGazeOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound)
    return refuse("study gaze", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  const Result<StudyScene> scene = StudyScene::make(o.common, kGazeScene);
  if (!scene) return refuse("study gaze", scene.error());
  const Result<scheduler::Policy> policy = policy_of(o, scene.value().scene());
  if (!policy) return refuse("study gaze", kExitBadUsage, policy.error().message);
  const GazeSettings settings = settings_of(o, policy.value());
  const Result<GazeRun> run = measured(o, scene.value(), settings);
  if (!run) return refuse("study gaze", run.error());
  const std::uint64_t seed = scene.value().scene().seed;
  io::StudyTable table = begin_study("gaze", "poise study gaze");
  table.facts = {{"scene", scene.value().name()},
                 {"bodies", settings.bodies},
                 {"seeds", settings.seeds},
                 {"states", static_cast<std::uint64_t>(run.value().states.size())},
                 {"states_not_converged", run.value().not_converged},
                 {"budget_percent", 100 * settings.budget_share},
                 {"full_units", run.value().full_units},
                 {"state_full_units", mean_full_units(run.value())},
                 {"shake_mps", settings.shake.speed_mps}};
  add_gaze_tables(run.value(), seed, table);
  const Status written = write_study(o.common, table, gaze_charts(run.value()), gaze_plot(run.value(), seed));
  return written ? kExitDone : refuse("study gaze", written.error());
}

}  // namespace poise::app
