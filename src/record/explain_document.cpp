// SPDX-License-Identifier: MIT
#include "record/explain_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>

#include "frame/stage_list.h"
#include "scene/run/milliseconds.h"
#include "scene/run/policy_name.h"
#include "scene/run/run_report.h"

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;
using Kind = RefinementStep::Kind;

constexpr double kDegrees = 180.0 / std::numbers::pi;

struct OutcomeText {
  PairOutcome outcome;
  const char* key;
  const char* text;
};
constexpr std::array kOutcomes{
    OutcomeText{PairOutcome::KnownApart, "known_apart", "known from an earlier frame to be apart: nothing to do"},
    OutcomeText{PairOutcome::KnownPoints, "known_points",
                "answered by contact points known from an earlier frame: nothing more to gain"},
    OutcomeText{PairOutcome::Mandatory, "mandatory", "of a fast body: refined whole, whatever the budget"},
    OutcomeText{PairOutcome::FoundApart, "found_apart", "refined and found apart"},
    OutcomeText{PairOutcome::Deepest, "deepest", "refined to the deepest level: nothing more to gain"},
    OutcomeText{PairOutcome::Reused, "reused", "left as it was answered last, because the frame was infeasible"},
    OutcomeText{PairOutcome::CutOff, "cut_off", "left coarse: its next level was begun and did not end in time"},
    OutcomeText{PairOutcome::FrontFull, "front_full", "left coarse: its front was full"},
    OutcomeText{PairOutcome::Unseen, "unseen", "left coarse: what remains of its error is below the threshold"},
    OutcomeText{PairOutcome::Unserved, "unserved", "left coarse: the budget was used up before its turn"},
};

const OutcomeText& text_of(PairOutcome outcome) {
  return *std::find_if(kOutcomes.begin(), kOutcomes.end(),
                       [outcome](const OutcomeText& text) { return text.outcome == outcome; });
}

bool left_coarse(PairOutcome outcome) {
  return outcome == PairOutcome::CutOff || outcome == PairOutcome::FrontFull || outcome == PairOutcome::Unseen ||
         outcome == PairOutcome::Unserved;
}

const char* why_left(PairOutcome outcome) {
  switch (outcome) {
    case PairOutcome::CutOff:
      return "begun, cut off";
    case PairOutcome::FrontFull:
      return "front full";
    case PairOutcome::Unseen:
      return "below the threshold";
    default:
      return "budget used up";
  }
}

std::ptrdiff_t count_of(const ExplainedFrame& e, PairOutcome outcome) {
  const auto apart = static_cast<std::ptrdiff_t>(e.explanation.pairs_apart);
  return std::ranges::count(e.explanation.pairs, outcome, &PairExplanation::outcome) +
         (outcome == PairOutcome::KnownApart ? apart : 0);
}

/// A completed level, with its position in time.
struct Turn {
  std::size_t order = 0;  ///< from 1
  std::uint8_t worker = 0;
  const LevelExplanation* level = nullptr;
};

std::vector<Turn> turns_of(const ExplainedFrame& e) {
  const std::vector<LevelExplanation>& levels = e.explanation.levels;
  // Index of the first level of each pair.
  std::vector<std::size_t> next(e.explanation.pairs.size(), levels.size());
  for (std::size_t k = levels.size(); k-- > 0;) next[levels[k].pair] = k;
  std::vector<Turn> turns;
  for (const RefinementStep& step : e.frame.decisions.steps) {
    if (step.kind != Kind::Completed || step.pair >= next.size()) continue;
    const std::size_t k = next[step.pair]++;
    if (k < levels.size() && levels[k].pair == step.pair) turns.push_back({turns.size() + 1, step.worker, &levels[k]});
  }
  return turns;
}

std::vector<std::size_t> left_by_score(const ExplainedFrame& e) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < e.explanation.pairs.size(); ++i) {
    if (left_coarse(e.explanation.pairs[i].outcome)) left.push_back(i);
  }
  std::stable_sort(left.begin(), left.end(), [&](std::size_t x, std::size_t y) {
    return e.explanation.pairs[x].next_score > e.explanation.pairs[y].next_score;
  });
  return left;
}

const char* cache_use_word(PairExplanation::CacheUse use) {
  switch (use) {
    case PairExplanation::CacheUse::None:
      return "-";
    case PairExplanation::CacheUse::Separated:
      return "apart";
    case PairExplanation::CacheUse::Points:
      return "points";
    case PairExplanation::CacheUse::Expired:
      return "expired";
    case PairExplanation::CacheUse::Parted:
      return "parted";
  }
  return "-";
}

NamedBody body_of(const ExplainedFrame& e, const BodyId& id) {
  return id.slot < e.bodies.size() ? e.bodies[id.slot] : NamedBody{};
}

std::string shown(const ExplainedFrame& e, const BodyId& id) {
  constexpr std::size_t kLongest = 12;
  const NamedBody body = body_of(e, id);
  const std::string name = body.name.size() > kLongest ? body.name.substr(0, kLongest - 1) + "~" : body.name;
  return fmt::format("{} {}", body.number, name);
}

std::string named(const ExplainedFrame& e, std::uint32_t slot) { return shown(e, {slot, 0}); }

std::string cue_cells(const PairExplanation& pair) {
  const scheduler::PairCues& c = pair.cues;
  return fmt::format("{:>8.3g} {:>7.2f} {:>8.4f} {:>7.1f} {:>11.3g} {:>6} {:>7.3g} {:>7.2f}", pair.weight, c.visibility,
                     c.angle_radpm, c.eccentricity_rad * kDegrees, c.closing_mps, c.frames_waited, c.importance,
                     c.separation);
}

constexpr const char* kCueHeads = "  weight visible    rad/m ecc deg closing m/s waited  import   apart";

std::string shares(std::size_t shown, std::size_t all) {
  return shown < all ? fmt::format("{} of {}; --limit 0 shows all", shown, all) : fmt::format("{}", all);
}

/// Why the frame was late, and the time of each stage; of refinement, with the work that it did in it.
std::string times_of(const ExplainedFrame& e, const std::vector<Turn>& turns) {
  if (!e.frame.times) return "times: none, since the run counted work\n";
  const RecordedTimes& t = *e.frame.times;
  std::string text;
  if (e.frame.lateness.count() > 0) {
    text += fmt::format("late by {:.3f} ms: {}, {}\n", ms(e.frame.lateness), simulation::cause_name(t.cause),
                        simulation::cause_text(t.cause));
  } else {
    text += "in time\n";
  }
  if (t.release_delay.count() > 0) text += fmt::format("began {:.3f} ms after its release\n", ms(t.release_delay));
  text += "stages in ms:";
  for (const simulation::StageMember& stage : simulation::kStages)
    text += fmt::format(" {} {:.3f}", stage.name, ms(t.stages.*stage.time));
  if (t.host.count() > 0) text += fmt::format(" host {:.3f}", ms(t.host));
  if (!e.frame.decisions.unfinished) {
    std::uint64_t units = 0;
    for (const Turn& turn : turns) units += turn.level->units;
    text += fmt::format("\nrefine: {} units completed", units);
    if (t.piece.count() > 0) {
      text += fmt::format("; longest piece {:.3f} ms, bodies {} and {}", ms(t.piece), named(e, t.piece_a),
                          named(e, t.piece_b));
    }
  }
  return text + "\n";
}

std::string head_of(const ExplainedFrame& e, const std::vector<Turn>& turns) {
  const RecordedFrame& f = e.frame;
  std::vector<bool> served(e.explanation.pairs.size(), false);
  for (const Turn& turn : turns) served[turn.level->pair] = true;
  std::string text =
      fmt::format("frame {}: {} active pairs, and {} known to be apart; {} levels of {} pairs completed\n",
                  f.decisions.frame, e.explanation.pairs.size(), e.explanation.pairs_apart, turns.size(),
                  std::count(served.begin(), served.end(), true));
  if (e.wall_clock) {
    text += fmt::format(
        "time: {:.3f} ms from the start to the deadline, {:.3f} ms for refinement, {:.3f} ms kept for what came after "
        "it\n",
        ms(f.budget), ms(f.refine_available), ms(f.reserve));
  }
  text += times_of(e, turns);
  if (f.decisions.point_iterations > 0)
    text +=
        fmt::format("resting contact had time for {} point iterations in a substep\n", f.decisions.point_iterations);
  if (!f.decisions.stopped_after.empty())
    text += fmt::format(
        "resting contact was stopped by the clock after {} iterations in its substeps (0: it ended by itself)\n",
        fmt::join(f.decisions.stopped_after, " and "));
  if (f.decisions.crowded_partners > 0)
    text += fmt::format("no time for all pairs of crowds: {} for each body in one\n", f.decisions.crowded_partners);
  if (f.decisions.substeps > 0)
    text += fmt::format("infeasible: resting contact had {} substeps only\n", f.decisions.substeps);
  if (!f.decisions.held.empty())
    text += fmt::format("no time for all: islands waited, {} of them\n", f.decisions.held.size());
  if (f.decisions.resumed) text += "time for all: all islands that had waited took part again\n";
  if (!f.decisions.paused.empty()) {
    const auto longest = std::max_element(f.decisions.paused.begin(), f.decisions.paused.end(),
                                          [](const auto& x, const auto& y) { return x.steps < y.steps; });
    text += fmt::format("no time for all: {} islands wait after it for up to {} frames\n", f.decisions.paused.size(),
                        longest->steps);
  }
  const scheduler::Policy& p = e.explanation.policy;
  text += fmt::format("policy: {}", policy_name(p.kind));
  if (p.kind == scheduler::PolicyKind::Perceptual) {
    text += "; exponents of the cues:";
    for (const scheduler::PolicyField& weight : scheduler::policy_weights()) {
      const bool first = &weight == scheduler::policy_weights().data();
      text += fmt::format("{} {} {:g}", first ? "" : ",", weight.name, p.*weight.value);
    }
  }
  return text + "\n";
}

std::string refined_table(const ExplainedFrame& e, const std::vector<Turn>& turns, std::size_t limit) {
  const std::size_t rows = limit == 0 ? turns.size() : std::min(limit, turns.size());
  std::string text = fmt::format("\nrefined, in the order in which levels ended ({})\n", shares(rows, turns.size()));
  text += fmt::format("{:>6} {:>6}  {:<18} {:<18} {:>5} {:>6} {:>10} {}  then\n", "order", "thread", "body", "body",
                      "level", "units", "score", kCueHeads);
  for (std::size_t k = 0; k < rows; ++k) {
    const LevelExplanation& level = *turns[k].level;
    const PairExplanation& pair = e.explanation.pairs[level.pair];
    const bool polygons = pair.polygons && level.level == pair.deepest;
    text += fmt::format("{:>6} {:>6}  {:<18} {:<18} {:>5} {:>6} {:>10.4g} {}  {}\n", turns[k].order, turns[k].worker,
                        shown(e, pair.a), shown(e, pair.b), polygons ? "poly" : fmt::format("{}", level.level),
                        level.units, level.score, cue_cells(pair), level.ended ? "apart" : "contact");
  }
  return text;
}

std::string left_table(const ExplainedFrame& e, std::size_t limit) {
  const std::vector<std::size_t> left = left_by_score(e);
  const std::size_t rows = limit == 0 ? left.size() : std::min(limit, left.size());
  std::string text = fmt::format("\nleft coarse, the highest score first ({})\n", shares(rows, left.size()));
  if (left.empty()) return text;
  text += fmt::format("{:<18} {:<18} {:>5} {:>7} {:>7} {:>6} {:>10} {}  why\n", "body", "body", "level", "deepest",
                      "cached", "units", "score", kCueHeads);
  for (std::size_t k = 0; k < rows; ++k) {
    const PairExplanation& pair = e.explanation.pairs[left[k]];
    text += fmt::format("{:<18} {:<18} {:>5} {:>7} {:>7} {:>6} {:>10.4g} {}  {}\n", shown(e, pair.a), shown(e, pair.b),
                        pair.level, pair.deepest, cache_use_word(pair.cached), pair.next_units, pair.next_score,
                        cue_cells(pair), why_left(pair.outcome));
  }
  return text;
}

Json pair_json(const ExplainedFrame& e, const PairExplanation& pair) {
  const scheduler::PairCues& c = pair.cues;
  return {{"a", body_of(e, pair.a).number},
          {"b", body_of(e, pair.b).number},
          {"weight", pair.weight},
          {"cues",
           {{"visibility", c.visibility},
            {"angle_radpm", c.angle_radpm},
            {"eccentricity_rad", c.eccentricity_rad},
            {"closing_mps", c.closing_mps},
            {"frames_waited", c.frames_waited},
            {"importance", c.importance},
            {"host", c.host},
            {"hidden", c.hidden},
            {"gap_rad", c.gap_rad},
            {"delay_s", c.delay_s},
            {"age_s", c.age_s},
            {"separation", c.separation},
            {"crowd", c.crowd},
            {"attended", c.attended}}},
          {"cached", cache_use_word(pair.cached)},
          {"cached_level", pair.cached_level},
          {"deepest", pair.deepest},
          {"polygons", pair.polygons}};
}

Json counts_json(const ExplainedFrame& e) {
  Json counts = Json::object();
  for (const OutcomeText& text : kOutcomes) counts[text.key] = count_of(e, text.outcome);
  return counts;
}

Json paused_json(const FrameDecisions& decisions) {
  Json islands = Json::array();
  for (const PausedIsland& island : decisions.paused)
    islands.push_back({{"root", island.root}, {"steps", island.steps}});
  return islands;
}

Json times_json(const ExplainedFrame& e) {
  if (!e.frame.times) return nullptr;
  const RecordedTimes& t = *e.frame.times;
  Json stages = Json::object();
  for (const simulation::StageMember& stage : simulation::kStages) stages[stage.name] = ms(t.stages.*stage.time);
  Json piece = nullptr;
  if (t.piece.count() > 0) {
    piece = {{"ms", ms(t.piece)}, {"a", body_of(e, {t.piece_a, 0}).number}, {"b", body_of(e, {t.piece_b, 0}).number}};
  }
  return {{"cause", simulation::cause_name(t.cause)},
          {"release_delay_ms", ms(t.release_delay)},
          {"host_ms", ms(t.host)},
          {"stage_ms", std::move(stages)},
          {"longest_piece", std::move(piece)}};
}

}  // namespace

std::vector<NamedBody> bodies_by_slot(const Scene& scene, const SceneRun& run) {
  std::vector<NamedBody> named;
  const std::span<const RunBody> bodies = run.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t slot = bodies[i].id.slot;
    if (slot >= named.size()) named.resize(slot + std::size_t{1});
    NamedBody& body = named[slot];
    body.number = bodies[i].number;
    if (i < scene.bodies.size()) body.name = scene.bodies[i].name;
    if (body.name.empty())
      body.name = bodies[i].shape < scene.shapes.size() ? scene.shapes[bodies[i].shape].name : "tray";
  }
  return named;
}

std::string explain_table(const ExplainedFrame& e, std::size_t limit) {
  if (e.frame.decisions.unfinished) {
    return fmt::format(
               "frame {}: its step did not end in it, and nothing moved; what it did is told of the frame that ends "
               "it\n",
               e.frame.decisions.frame) +
           times_of(e, {});
  }
  const std::vector<Turn> turns = turns_of(e);
  std::string text = head_of(e, turns) + "\npairs by what became of them\n";
  for (const OutcomeText& outcome : kOutcomes) {
    const std::ptrdiff_t count = count_of(e, outcome.outcome);
    if (count > 0) text += fmt::format("{:>7}  {}\n", count, outcome.text);
  }
  return text + refined_table(e, turns, limit) + left_table(e, limit);
}

nlohmann::ordered_json explain_json(const ExplainedFrame& e) {
  Json refined = Json::array();
  for (const Turn& turn : turns_of(e)) {
    const LevelExplanation& level = *turn.level;
    Json row = {{"order", turn.order},  {"worker", turn.worker}, {"level", level.level},
                {"units", level.units}, {"score", level.score},  {"apart", level.ended}};
    row.update(pair_json(e, e.explanation.pairs[level.pair]));
    refined.push_back(std::move(row));
  }
  Json left = Json::array();
  for (const std::size_t i : left_by_score(e)) {
    const PairExplanation& pair = e.explanation.pairs[i];
    Json row = {{"why", text_of(pair.outcome).key},
                {"level", pair.level},
                {"next_units", pair.next_units},
                {"next_score", pair.next_score}};
    row.update(pair_json(e, pair));
    left.push_back(std::move(row));
  }
  const RecordedFrame& f = e.frame;
  const auto of_step = [&](std::size_t count) { return f.decisions.unfinished ? Json(nullptr) : Json(count); };
  return {{"frame", f.decisions.frame},
          {"policy", policy_name(e.explanation.policy.kind)},
          {"unfinished", f.decisions.unfinished},
          {"active_pairs", of_step(e.explanation.pairs.size())},
          {"pairs_apart", of_step(e.explanation.pairs_apart)},
          {"budget_ms", ms(f.budget)},
          {"refine_available_ms", ms(f.refine_available)},
          {"reserve_ms", ms(f.reserve)},
          {"lateness_ms", ms(f.lateness)},
          {"times", times_json(e)},
          {"substeps", f.decisions.substeps},
          {"held", f.decisions.held},
          {"paused", paused_json(f.decisions)},
          {"resumed", f.decisions.resumed},
          {"point_iterations", f.decisions.point_iterations},
          {"stopped_after", f.decisions.stopped_after},
          {"crowded_partners", f.decisions.crowded_partners},
          {"pairs", counts_json(e)},
          {"refined", std::move(refined)},
          {"left_coarse", std::move(left)}};
}

}  // namespace poise::io
