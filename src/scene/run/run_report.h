// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "frame/stage_list.h"
#include "poise/step.h"
#include "scene/run/percentiles.h"
#include "scene/run/reference_run.h"

namespace poise::simulation {

/// One frame of a run with the measurements of its caller.
struct RunFrame {
  FrameReport report;
  bool warm_up = false;                ///< simulated, but excluded from the figures
  std::uint64_t releases_skipped = 0;  ///< paced runs: releases that passed while this frame was still running
  /// Numbers of the bodies of FrameReport::longest_job, where a report may name them.
  std::array<std::uint64_t, 2> longest_job_bodies{};
  /// Number of FrameReport::out_of_range_body, where there is one.
  std::uint64_t out_of_range_body = 0;
};

/// Why a frame of a run was late whose report says MissCause::Release: the cause of the frame before it, if that one
/// was late and still running at the release; the machine, if the run had `waited` for the release and was woken late;
/// else it stays (frames on time that run past the next release).
MissCause cause_of_release(MissCause before, bool waited);

/// Settings that affect the figures of a run, besides its frames.
struct RunTerms {
  bool deadlines = true;  ///< wall clock: a late frame is a miss; otherwise misses are not defined
  double alpha = 0.01;    ///< share of frames whose tail may take longer than its reserve
};

struct Interval {
  double low = 0, high = 1;
};
/// Exact interval of Clopper and Pearson ("The use of confidence or fiducial limits", Biometrika 1934) for `hits` of
/// `trials` at the given confidence in (0, 1); [0, 1] without a trial.
Interval clopper_pearson(std::uint64_t hits, std::uint64_t trials, double confidence);
/// Regularised incomplete beta function I_x(a, b), a and b > 0, x in [0, 1], to 1e-12 for a + b up to 10^4; the error
/// grows with the logarithms of the factorials.
double incomplete_beta(double a, double b, double x);

/// Late frames and skipped releases. `count` is the sum of the five causes; a skipped release has the cause of the
/// frame that was running.
struct MissFigures {
  std::uint64_t count = 0;
  std::uint64_t releases = 0;  ///< frames and skipped releases
  double rate = 0;             ///< count / releases
  Interval interval_95;
  std::uint64_t release = 0, infeasible = 0, machine = 0, overrun = 0, forecast = 0;
  std::uint64_t skipped_releases = 0;
  std::uint64_t longest_run = 0;  ///< of consecutive missed releases
  std::uint64_t worst_1000 = 0;   ///< most misses among 1000 consecutive frames
  Percentiles tardiness_ms;       ///< of late frames
  double share_of_time_late = 0;  ///< sum of lateness / sum of frame times
};

/// Quality of the reserve for the tail, over frames that had a forecast. But for reserve_used the tail is what had to
/// be done (FrameReport::tail_needed).
struct TailFigures {
  std::uint64_t frames = 0;
  double coverage = 0;               ///< share of frames whose tail took no longer than its reserve
  double reserve_over_actual = 0;    ///< sum of the reserves / sum of the tails
  double reserve_used = 0;           ///< sum of min(whole tail, reserve) / sum of reserves
  Percentiles actual_over_forecast;  ///< for the point forecast, without margin
  /// Mean pinball loss of the reserve as a forecast of the (1 - alpha) quantile of the tail (Koenker and Bassett,
  /// "Regression quantiles", Econometrica 1978): (1 - alpha) times the missing time, or alpha times the excess time.
  double pinball_loss_ms = 0;
  double margin_last = 1;
  std::uint64_t beyond_clip = 0;  ///< frames whose ratio actual / forecast is outside the range of the bound on missed
                                  ///< deadlines
};

/// Frames that left out work because it was forecast not to fit, and the work that they left out.
struct DegradedFigures {
  std::uint64_t frames = 0;               ///< that left out work
  std::uint64_t fewer_iterations = 0;     ///< of these, frames whose contact solver stopped before it converged
  std::uint64_t fewer_partners = 0;       ///< and frames in which bodies in crowds did not keep all their pairs
  std::uint64_t fewer_substeps = 0;       ///< of these, frames with fewer substeps
  std::uint64_t pairs_reused = 0;         ///< sum over the frames
  std::uint64_t frames_held = 0;          ///< frames in which islands waited
  std::uint64_t bodies_held = 0;          ///< sum over the frames
  std::uint64_t bodies_paused = 0;        ///< of these, that waited for several frames and were not looked at
  std::uint64_t frames_unfinished = 0;    ///< frames whose step went on in the next one
  std::uint64_t infeasible_forecast = 0;  ///< frames whose mandatory work was forecast not to fit
};

/// Levels reached, over the frames with StepInput::measure_levels. Arrays are indexed by level; the last entry is
/// polygons.
struct LevelFigures {
  std::uint64_t frames = 0;
  std::array<std::uint64_t, kPolygonBin + 1> bodies{};  ///< by the lowest level of their contacts
  /// Share of the visual weight, by the level of the contact; sums to 1 unless there is none.
  std::array<double, kPolygonBin + 1> weight{};
  double left_for_time_mean = 0, left_for_capacity_mean = 0;  ///< pairs
  std::uint32_t longest_wait = 0;  ///< starvation: most frames since a pair that was left coarse was refined beyond
                                   ///< level 0
};

struct StageFigures {
  const char* name = "";
  Percentiles ms;
};

struct WorkFigures {
  double mandatory_mean = 0, refine_mean = 0;
  std::uint64_t mandatory = 0, refine = 0;
  std::uint64_t jobs_done = 0, jobs_discarded = 0, jobs_abandoned = 0, pairs_separated = 0;
  std::uint64_t cached_separations = 0, cached_contacts = 0;
  double candidate_pairs_mean = 0, coarse_pairs_mean = 0, pairs_left_mean = 0;
  std::uint64_t frames_with_pairs_left = 0;
};

/// Statistics of sleeping bodies (WorldSettings::sleeping).
struct SleepFigures {
  std::uint64_t asleep_end = 0;              ///< number after the last frame
  double asleep_mean = 0;                    ///< mean number after a frame
  std::uint64_t fell_asleep = 0, woken = 0;  ///< sums over the frames
};

/// Sums of work discarded because a capacity was full; all 0 in a healthy run.
struct CapacityFigures {
  std::uint64_t pairs_discarded = 0, fronts_full = 0, colors_full = 0, degenerate = 0;
};

/// Bodies that came to rest where they were because a step would have taken them out of range, warm-up included.
struct OutOfRangeFigures {
  std::uint64_t bodies = 0;                       ///< sum over the frames
  std::uint64_t first_frame = 0, first_body = 0;  ///< where bodies > 0; as in LongestJob
};

/// Sums of backtracking over the frames.
struct SweptFigures {
  std::uint64_t pairs = 0, hits = 0, cut = 0;
};

/// The longest piece of refinement: where a scene has a shape that is too dear for its deadline.
struct LongestJob {
  std::uint64_t frame = 0;               ///< FrameReport::frame
  std::uint64_t body_a = 0, body_b = 0;  ///< numbers: bodies count from 0 in the order of the scene
};

/// One of the frames that were late by most.
struct WorstFrame {
  std::uint64_t frame = 0;  ///< FrameReport::frame: warm-up included, as replays count
  Nanoseconds lateness{0};
  MissCause cause = MissCause::None;
  Nanoseconds release_delay{0};
  const char* stage = "";  ///< the longest one, or `host`
  Nanoseconds stage_time{0};
  std::optional<LongestJob> piece;  ///< the longest one, if it was the cause
  Nanoseconds piece_time{0};
};
inline constexpr std::size_t kWorstFrames = 5;
/// At most kWorstFrames late ones, the latest first.
std::vector<WorstFrame> worst_frames(std::span<const RunFrame> frames);

struct RunFigures {
  std::uint64_t frames = 0;  ///< without warm-up
  std::uint64_t warm_up_frames = 0;
  std::uint64_t warm_up_misses = 0;
  Percentiles frame_ms;            ///< StageTimes::total
  double low_1_percent_fps = 0;    ///< frames a second over the slowest hundredth (at least one frame)
  double low_0_1_percent_fps = 0;  ///< the same for the slowest thousandth
  Percentiles release_delay_ms;
  std::optional<MissFigures> misses;     ///< undefined on the work clock
  std::vector<WorstFrame> worst_frames;  ///< at most kWorstFrames late ones, the latest first
  /// Time used for refinement / time available for it, over the frames that ended with refinable pairs left. Undefined
  /// without such a frame. Above 1 if refinement exceeded its end.
  std::optional<double> refinement_used;
  std::optional<double> refinement_used_all;  ///< the same over all frames with time available
  TailFigures tail;
  DegradedFigures degraded;
  std::array<StageFigures, kStages.size() + 1> stages;  ///< and last the whole frame, "total"
  double off_cpu_ms_max = 0;
  double longest_job_ms_max = 0;
  std::optional<LongestJob> longest_job;  ///< undefined on the work clock
  std::optional<double> level_mean;       ///< over contact pairs of all frames by their trees; undefined without one
  std::array<std::uint64_t, kMaxTreeDepth + 1> level_histogram{};  ///< contact pairs by the level of their trees
  std::uint64_t polygon_contacts = 0;  ///< contact pairs by polygons; not in the histogram and the mean
  double contacts_mean = 0;
  LevelFigures levels;
  WorkFigures work;
  CapacityFigures capacity;
  OutOfRangeFigures out_of_range;
  SweptFigures swept;
  SleepFigures sleep;
  ReferenceRunFigures reference;

  /// Frames for each step that ended in them: 1 unless steps take several. Undefined where none ended.
  [[nodiscard]] std::optional<double> frames_a_step() const {
    const std::uint64_t ended = frames - degraded.frames_unfinished;
    if (ended == 0) return std::nullopt;
    return static_cast<double>(frames) / static_cast<double>(ended);
  }
  /// Bodies that waited, a frame.
  [[nodiscard]] double held_mean() const {
    return frames == 0 ? 0 : static_cast<double>(degraded.bodies_held) / static_cast<double>(frames);
  }
};

/// Computes the figures of a run. A pure function of the frames and terms; no clock.
RunFigures run_figures(std::span<const RunFrame> frames, const RunTerms& terms);

/// `none`, `release`, `infeasible`, `machine`, `overrun` or `forecast`.
const char* cause_name(MissCause cause);
/// The same as half a sentence for a person.
const char* cause_text(MissCause cause);

}  // namespace poise::simulation
