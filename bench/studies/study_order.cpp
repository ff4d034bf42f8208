// SPDX-License-Identifier: MIT
#include "studies/study_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "scene/policy_file.h"
#include "scene/run/milliseconds.h"
#include "verify/shared_reference.h"

namespace poise::app {
namespace {

constexpr const char* kOrderScene = "jacks";
constexpr std::uint64_t kOrderFrames = 120;
constexpr std::uint64_t kOrderWarmUp = 60;
constexpr std::uint64_t kOrderEvery = 4;
constexpr std::uint64_t kOrderMostBodies = 200'000;

StepInput order_input(const Scene& scene, const SceneRun& run) {
  StepInput input;
  input.dt_s = scene.dt_s;
  input.max_level = scene.max_level;
  input.polygons = scene.polygons;
  input.backtracking = scene.backtracking;
  input.view = run.view();
  return input;
}

// Frames of one state, each of which begins at it.
class OrderState {
 public:
  OrderState(World& world, const StepInput& input) : world_(world), input_(input) { saved_.save(world); }

  // As the run does it.
  Result<FrameReport> go(const OrderRun& how, FrameDecisions* decisions) {
    StepInput once = input_;
    once.record = decisions != nullptr;
    if (how.deadline) {
      once.budget = Budget::within(*how.deadline);
    } else {
      const Result<FrameReport> full = step(input_);
      if (!full) return full;
      const double units = how.share.value_or(1) * static_cast<double>(full.value().work_refine);
      once.budget = Budget::work(static_cast<std::uint64_t>(std::llround(units)));
    }
    const Result<FrameReport> frame = step(once);
    if (frame && decisions != nullptr) world_.decisions(*decisions);
    return frame;
  }

  // Likewise, and what it did against everything that there was to do.
  Result<OrderFrame> look(const OrderRun& how) {
    FrameDecisions decisions, everything;
    const Result<FrameReport> frame = go(how, &decisions);
    if (!frame) return frame.error();
    StepInput full = input_;
    full.record = true;
    Result<FrameReport> done = step(full);
    if (!done) return done.error();
    world_.decisions(everything);
    FrameExplanation all;
    done = step_again(everything, &all);
    if (done) done = step_again(decisions, nullptr);
    if (!done) return done.error();
    return OrderFrame{frame.value(), order_figures(decisions, all)};
  }

 private:
  Result<FrameReport> step_again(const FrameDecisions& decisions, FrameExplanation* explanation) {
    StepInput again = input_;
    again.replay = &decisions;
    again.explain = explanation;
    return step(again);
  }
  Result<FrameReport> step(const StepInput& input) {
    saved_.rewind(world_);
    const FrameReport report = world_.step(input);
    if (report.status == StepStatus::Done) return report;
    return bad_input("a step was refused, or could not be done again");
  }

  World& world_;
  StepInput input_;
  simulation::SharedReference saved_;
};

// Counts of frames of one run, as they go into a row.
struct Sums {
  // Times are of all frames but `ranked_ms`, ranking where a pair was ranked.
  std::uint64_t frames = 0, left_out = 0, ranked_frames = 0, candidates = 0, ranked = 0, done = 0, full = 0,
                misplaced = 0, jobs = 0;
  double worst = 0, refine_ms = 0, ranking_ms = 0, ranked_ms = 0;
};

Sums sums_of(const std::vector<OrderFrame>& frames) {
  Sums sums;
  for (const OrderFrame& frame : frames) {
    const OrderFigures& f = frame.figures;
    // What is left out because the frame would be late has no turn.
    if (frame.report.degraded.pairs_reused > 0) {
      ++sums.left_out;
      continue;
    }
    ++sums.frames;
    sums.candidates += frame.report.candidate_pairs;
    sums.done += f.done;
    sums.full += f.full;
    sums.misplaced += f.misplaced;
    if (f.done > 0) sums.worst = std::max(sums.worst, static_cast<double>(f.misplaced) / static_cast<double>(f.done));
    sums.jobs += frame.report.jobs_done;
    sums.refine_ms += ms(frame.report.times.refine);
    sums.ranking_ms += ms(frame.report.ranking);
    // Where pairs go in the order of memory, none is ranked.
    if (frame.report.pairs_ranked == 0) continue;
    ++sums.ranked_frames;
    sums.ranked += frame.report.pairs_ranked;
    sums.ranked_ms += ms(frame.report.ranking);
  }
  return sums;
}

io::StudyCell percent(double part, double whole) {
  return whole > 0 ? io::StudyCell(100 * part / whole) : io::StudyCell();
}

std::vector<io::StudyCell> row_of(std::uint64_t bodies, const OrderRun& how, const std::vector<OrderFrame>& frames) {
  const Sums s = sums_of(frames);
  const double n = static_cast<double>(std::max<std::uint64_t>(s.frames, 1));
  const double ranked_n = static_cast<double>(std::max<std::uint64_t>(s.ranked_frames, 1));
  // A score after a level reads what ranking has found, so it takes less than ranking a pair does.
  const double score_ms = s.ranked > 0 ? s.ranked_ms / static_cast<double>(s.ranked) : 0;
  const bool wall = how.deadline.has_value();
  return {bodies,
          wall ? io::StudyCell(ms(*how.deadline)) : io::StudyCell(),
          how.share ? io::StudyCell(100 * *how.share) : io::StudyCell(),
          s.frames,
          s.left_out,
          static_cast<double>(s.candidates) / n,
          percent(static_cast<double>(s.done), static_cast<double>(s.full)),
          percent(static_cast<double>(s.misplaced), static_cast<double>(s.done)),
          100 * s.worst,
          wall ? io::StudyCell(s.ranked_frames) : io::StudyCell(),
          wall ? io::StudyCell(static_cast<double>(s.ranked) / ranked_n) : io::StudyCell(),
          wall ? percent(s.ranking_ms, s.refine_ms) : io::StudyCell(),
          s.ranked > 0 ? percent(static_cast<double>(s.jobs) * score_ms, s.refine_ms) : io::StudyCell(),
          s.ranked > 0 ? io::StudyCell(1e6 * score_ms) : io::StudyCell()};
}

const std::vector<io::StudyColumn> kOrderColumns = {{"bodies", "bodies", 0},
                                                    {"deadline_ms", "deadline ms", 1},
                                                    {"budget_percent", "budget %", 1},
                                                    {"frames", "frames", 0},
                                                    {"frames_left_out", "frames left out", 0},
                                                    {"candidate_pairs", "candidate pairs", 0},
                                                    {"work_percent", "of all work %", 1},
                                                    {"misplaced_percent", "misplaced %", 2},
                                                    {"misplaced_worst_percent", "worst frame %", 2},
                                                    {"frames_ranked", "frames ranked", 0},
                                                    {"pairs_ranked", "pairs ranked", 0},
                                                    {"ranking_percent", "ranking %", 1},
                                                    {"rescoring_percent", "scores of levels, at most %", 1},
                                                    {"ranking_ns", "ns a pair", 0}};

// A place for each row: its population, and its deadline or budget.
std::vector<LineChart> order_charts(const io::StudyTable& table) {
  LineChart chart{"order", "shares, %", "Misplaced: work that a sorted queue would have left out.", "runs", {}};
  std::vector<std::string> names;
  for (const auto& row : table.rows) {
    const auto* deadline = std::get_if<double>(&row[1]);
    const auto* budget = std::get_if<double>(&row[2]);
    names.push_back(fmt::format("{} bodies, {}", std::get<std::uint64_t>(row[0]),
                                deadline != nullptr ? fmt::format("{:g} ms", *deadline)
                                : budget != nullptr ? fmt::format("{:g} %", *budget)
                                                    : std::string("-")));
  }
  for (const auto& [column, label] :
       {std::pair("misplaced_percent", "misplaced"), std::pair("misplaced_worst_percent", "worst frame"),
        std::pair("ranking_percent", "time for ranking")}) {
    const auto at = std::ranges::find(kOrderColumns, column, &io::StudyColumn::name) - kOrderColumns.begin();
    ChartLine line{label, {}, LineMarks::Dots};
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      if (const auto* value = std::get_if<double>(&table.rows[i][static_cast<std::size_t>(at)]))
        line.points.push_back({static_cast<double>(i), *value, {}, {}});
    }
    chart.lines.push_back(std::move(line));
  }
  name_places(chart, std::move(names), "runs");
  return {std::move(chart)};
}

Status check(const StudyOrderOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound) return sound;
  if (o.budget_percent && !o.deadlines_ms.empty())
    return bad_input("only one of --deadlines and --budget can be given");
  return Done{};
}

std::vector<OrderRun> runs_of(const StudyOrderOptions& o) {
  OrderRun run;
  run.warm_up = o.common.warmup.value_or(kOrderWarmUp);
  run.frames = o.common.frames.value_or(kOrderFrames);
  run.every = o.every.value_or(kOrderEvery);
  if (o.budget_percent) {
    run.share = 0.01 * *o.budget_percent;
    return {run};
  }
  std::vector<OrderRun> runs;
  for (const double deadline : o.deadlines_ms.empty() ? std::vector<double>{3, 4, 6} : o.deadlines_ms) {
    run.deadline = Nanoseconds(static_cast<std::int64_t>(deadline * 1e6));
    runs.push_back(run);
  }
  return runs;
}

Result<io::StudyTable> measured(const StudyOrderOptions& o, const StudyScene& scene, Progress& progress) {
  Scene ranked = scene.scene();
  for (const std::string& weight : o.weights) {
    const Status set = io::set_weight(weight, ranked.policy);
    if (!set) return bad_input("--weight: " + set.error().message);
  }
  io::StudyTable table = begin_study("order", "poise study order");
  table.columns = kOrderColumns;
  table.facts = {{"scene", scene.name()}, {"threads", static_cast<std::uint64_t>(scene.threads())}};
  for (const std::uint64_t bodies : o.bodies.empty() ? std::vector<std::uint64_t>{2000} : o.bodies) {
    for (const OrderRun& how : runs_of(o)) {
      SceneRunOptions start = scene.start_options();
      start.bodies = bodies;
      start.world.policy = ranked.policy;
      start.world.sleeping = false;
      start.world.islands_wait = IslandsWait::Never;
      Result<SceneRun> run = SceneRun::create(ranked, start);
      if (!run) return run.error();
      const std::string doing = fmt::format("{} bodies, {}", bodies,
                                            how.deadline ? fmt::format("deadline {:g} ms", ms(*how.deadline))
                                                         : fmt::format("{:g} % of the work", 100 * *how.share));
      const Result<std::vector<OrderFrame>> frames =
          order_frames(ranked, run.value(), how, [&](double share) { progress.share(doing, share); });
      if (!frames) return frames.error();
      table.rows.push_back(row_of(bodies, how, frames.value()));
    }
  }
  return table;
}

}  // namespace

Result<std::vector<OrderFrame>> order_frames(const Scene& scene, SceneRun& run, const OrderRun& how,
                                             const std::function<void(double share)>& told) {
  const parallel::Interrupt interrupt;
  const std::uint64_t total = how.warm_up + how.frames;
  std::vector<OrderFrame> frames;
  for (std::uint64_t k = 0; k < total; ++k) {
    const Status ready = run.before_frame(k);
    if (!ready) return ready.error();
    OrderState state(run.world(), order_input(scene, run));
    if (k >= how.warm_up && (k - how.warm_up) % how.every == 0) {
      const Result<OrderFrame> frame = state.look(how);
      if (!frame) return frame.error();
      frames.push_back(frame.value());
    } else {
      const Result<FrameReport> frame = state.go(how, nullptr);
      if (!frame) return frame.error();
    }
    if (interrupt.asked()) return stopped_error();
    told(static_cast<double>(k + 1) / static_cast<double>(total));
  }
  return frames;
}

void add_study_order_options(CLI::App& command, StudyOrderOptions& o) {
  command.add_option("--bodies", o.bodies, "Populations, with commas between them (default 2000)")
      ->delimiter(',')
      ->check(CLI::Range(std::uint64_t{1}, kOrderMostBodies))
      ->type_name("LIST");
  command.add_option("--deadlines", o.deadlines_ms, "Deadlines in ms, with commas between them (default 3,4,6)")
      ->delimiter(',')
      ->check(numbers_within(0.001, 1e6))
      ->type_name("LIST");
  add_number(command, "--budget", o.budget_percent, 0, true, 100,
             "Counted work instead of deadlines, in % of full refinement of each frame");
  command.add_option("--weight", o.weights, "Exponent of a cue, as occlusion=1; may be given several times");
  add_whole(command, "--frames", o.common.frames, 1, kMaxSceneFrames,
            fmt::format("Frames of each run (default {})", kOrderFrames));
  add_whole(command, "--warmup", o.common.warmup, 0, kMaxSceneFrames,
            fmt::format("Frames before those (default {})", kOrderWarmUp));
  add_whole(command, "--every", o.every, 1, kMaxSceneFrames,
            fmt::format("Looks at each N-th frame (default {})", kOrderEvery));
  command
      .add_option("--scene", o.common.scene,
                  fmt::format("A scene with generators, by file or name (default {})", kOrderScene))
      ->type_name("SCENE");
  add_study_tables(command, o.common);
  command.footer(
      "Misplaced is the share of a frame's work that a queue sorted by score at all times would have left out, had it "
      "done as much.\n"
      "Ranking is the share of the time of refinement that goes into cues and scores before the first job; scores "
      "after "
      "levels are\n"
      "bounded by what ranking takes a pair. Frames in which pairs used contacts of an earlier one again are left "
      "out.");
}

int study_order(const StudyOrderOptions& o) {
  const Status sound = check(o);
  if (!sound)
    return refuse("study order", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  const Result<StudyScene> scene = StudyScene::make(o.common, kOrderScene);
  if (!scene) return refuse("study order", scene.error());
  Progress progress(!o.common.quiet);
  const Result<io::StudyTable> table = measured(o, scene.value(), progress);
  progress.end();
  if (!table) return refuse("study order", table.error());
  const Status written = write_study(o.common, table.value(), order_charts(table.value()), 1);
  return written ? kExitDone : refuse("study order", written.error());
}

}  // namespace poise::app
