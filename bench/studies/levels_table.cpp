// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "studies/levels_document.h"

namespace poise::io {
namespace {

using Cells = std::vector<std::string>;
/// The first row is the header.
using Table = std::vector<Cells>;

std::vector<simulation::ProbeLevel> levels_of(const LevelsDocument& document) {
  std::vector<simulation::ProbeLevel> levels;
  for (const LevelsRow& row : document.rows) {
    if (std::find(levels.begin(), levels.end(), row.level) == levels.end()) levels.push_back(row.level);
  }
  return levels;
}

std::string heading(simulation::ProbeLevel level) { return level.polygons ? "polygons" : "L" + level_name(level); }

// Mean error of dv: a line a pair and model, a column a level.
Table pair_table(const LevelsDocument& document) {
  Table table{{"pair", "group", "model"}};
  const auto levels = levels_of(document);
  for (const simulation::ProbeLevel level : levels) table[0].push_back(heading(level));
  table[0].emplace_back("oracle 1, 3 mm");
  for (std::size_t i = 0; i < document.rows.size();) {
    const LevelsRow& first = document.rows[i];
    const LevelsPair& pair = document.pairs[first.pair];
    Cells cells{pair.shape_a + " " + pair.shape_b, pair.group, first.model};
    cells.resize(3 + levels.size(), "-");
    for (; i < document.rows.size() && document.rows[i].pair == first.pair && document.rows[i].model == first.model;
         ++i) {
      const auto column = std::find(levels.begin(), levels.end(), document.rows[i].level) - levels.begin();
      cells[3 + static_cast<std::size_t>(column)] = fmt::format("{:.3f}", document.rows[i].dv.mean);
    }
    cells.push_back(fmt::format("{:.3f}, {:.3f}", pair.uncertainty, pair.uncertainty_three));
    table.push_back(std::move(cells));
  }
  return table;
}

// Means over the pairs of a group: a line a model and level.
Table summary_table(const LevelsDocument& document) {
  Table table{{"group", "model", "level", "dv mean", "to reach", "dv median", "dv p90", "dw mean", "toc ms", "late %",
               "unseen %", "refine ns", "overlap ns", "response ns"}};
  for (const LevelsSummary& s : summaries(document)) {
    const std::string target =
        s.target ? fmt::format("{:.2f}{}", *s.target, s.dv.mean <= *s.target ? "" : " missed") : "-";
    table.push_back({s.group, s.model, heading(s.level), fmt::format("{:.3f}", s.dv.mean), target,
                     fmt::format("{:.3f}", s.dv.median), fmt::format("{:.3f}", s.dv.p90),
                     fmt::format("{:.3f}", s.dw.mean), fmt::format("{:.1f}", s.toc_ms_mean),
                     fmt::format("{:.1f}", 100 * s.late_share), fmt::format("{:.1f}", 100 * s.unseen_share),
                     fmt::format("{:.0f}", s.cost.refine_ns), fmt::format("{:.0f}", s.cost.overlap_ns),
                     fmt::format("{:.0f}", s.cost.response_ns)});
  }
  return table;
}

// Largest of the other figures with targets, over the levels of a group and model.
struct Limits {
  std::string group, model;
  std::optional<double> toc_ms, late;  // at level 3
  double response_ns = 0, ratio = 0;
};

std::vector<Limits> limits_of(const LevelsDocument& document) {
  std::vector<Limits> all;
  for (const LevelsSummary& s : summaries(document)) {
    if (all.empty() || all.back().group != s.group || all.back().model != s.model)
      all.push_back({s.group, s.model, {}, {}, 0, 0});
    Limits& limits = all.back();
    if (s.level == simulation::ProbeLevel{3, false}) {
      limits.toc_ms = s.toc_ms_mean;
      limits.late = s.late_share;
    }
    limits.response_ns = std::max(limits.response_ns, s.cost.response_ns);
    const bool tested = s.level.level > 0 && !s.level.polygons && s.cost.overlap_ns > 0;
    if (tested) limits.ratio = std::max(limits.ratio, s.cost.refine_ns / s.cost.overlap_ns);
  }
  return all;
}

Table limits_table(const LevelsDocument& document) {
  Table table{{"group", "model", "toc ms at L3, <= 8", "late % at L3, <= 1", "response ns, <= 100",
               "refine / overlap, <= 1.5"}};
  const auto cell_of = [](std::optional<double> value, double most, double scale) {
    return value ? fmt::format("{:.1f}{}", scale * *value, *value <= most ? "" : " missed") : std::string("-");
  };
  for (const Limits& limits : limits_of(document)) {
    table.push_back({limits.group, limits.model, cell_of(limits.toc_ms, 8, 1), cell_of(limits.late, 0.01, 100),
                     cell_of(limits.response_ns, 100, 1), cell_of(limits.ratio, 1.5, 1)});
  }
  return table;
}

std::string setback_text(const LevelsDocument& document) {
  const std::vector<LevelsSetback> found = setbacks(document);
  if (found.empty())
    return "No level of any pair is worse than the one before by more than 2 % and the oracle's own uncertainty.\n";
  std::string text = "Levels worse than the one before by more than 2 % and the oracle's own uncertainty:\n";
  for (const LevelsSetback& setback : found) {
    const LevelsRow& row = document.rows[setback.row];
    const LevelsPair& pair = document.pairs[row.pair];
    text += fmt::format("- {} {}, {}, {}: {:.3f} after {:.3f}\n", pair.shape_a, pair.shape_b, row.model,
                        heading(row.level), row.dv.mean, setback.before);
  }
  return text;
}

std::string made_by(const LevelsDocument& d) {
  return fmt::format(
      "{} touches a pair, half: {}, seed {}, {:g} m/s, e = {:g}, trees of depth {}, fineness {}; {}, {} cores, {}; "
      "poise {} commit {}, {}\n",
      d.touches, d.half, d.seed, d.speed_mps, d.restitution, d.depth, d.fineness, d.machine.processor, d.machine.cores,
      d.machine.system, d.build.version, d.build.commit, d.build.compiler);
}

// The first `words` columns are text, the others figures.
std::string as_columns(const Table& table, std::size_t words) {
  std::vector<std::size_t> widths(table[0].size());
  for (const Cells& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const Cells& row : table) {
    std::string line = fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t i = 1; i < row.size(); ++i)
      line += i < words ? fmt::format("  {:<{}}", row[i], widths[i]) : fmt::format("  {:>{}}", row[i], widths[i]);
    text += line + "\n";
  }
  return text;
}

std::string as_markdown(const Table& table) {
  std::string text;
  for (std::size_t i = 0; i < table.size(); ++i) {
    text += "| " + fmt::format("{}", fmt::join(table[i], " | ")) + " |\n";
    if (i > 0) continue;
    for (std::size_t k = 0; k < table[0].size(); ++k) text += "|---";
    text += "|\n";
  }
  return text;
}

constexpr const char* kPairTitle =
    "Mean error of dv as a share of the exact answer's mean, and how much that moves with the pose:";
constexpr const char* kSummaryTitle =
    "Means over the pairs of a group. refine: from the roots to the contact of the level; overlap: its overlap tests "
    "alone; response: "
    "from the contact to both bodies' velocities:";
constexpr const char* kLimitsTitle = "What else is to be reached; the last two are the most of any level:";

}  // namespace

std::string levels_table(const LevelsDocument& document) {
  return fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}", kPairTitle, as_columns(pair_table(document), 3), kSummaryTitle,
                     as_columns(summary_table(document), 3), kLimitsTitle, as_columns(limits_table(document), 2),
                     setback_text(document), made_by(document));
}

std::string levels_markdown(const LevelsDocument& document) {
  return fmt::format("{}\n\n{}\n{}\n\n{}\n{}\n\n{}\n{}\n{}", kPairTitle, as_markdown(pair_table(document)),
                     kSummaryTitle, as_markdown(summary_table(document)), kLimitsTitle,
                     as_markdown(limits_table(document)), setback_text(document), made_by(document));
}

}  // namespace poise::io
