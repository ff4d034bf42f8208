// SPDX-License-Identifier: MIT
#include "studies/gaze_figures.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "scene/compare/comparison.h"
#include "scene/run/percentiles.h"

namespace poise::app {
namespace {

constexpr double kServed = 0.9;
constexpr std::uint64_t kSoon = 3;

std::optional<double> root_mean(double sum, std::uint64_t count) {
  return count > 0 ? std::optional(std::sqrt(sum / static_cast<double>(count))) : std::nullopt;
}

// Sums of eps^2 over bodies near a gaze point.
struct NearSums {
  std::uint64_t bodies = 0;
  double near = 0, elsewhere = 0, full = 0;
  void add(const NearSums& part) {
    bodies += part.bodies;
    near += part.near;
    elsewhere += part.elsewhere;
    full += part.full;
  }
};

double elsewhere_of(const GazeBody& body, std::size_t gaze_point) {
  double sum = 0;
  for (std::size_t other = 0; other < kGazePoints; ++other) sum += other == gaze_point ? 0 : body.eps2[other];
  return sum / static_cast<double>(kGazePoints - 1);
}

NearSums sums_of(const GazeState& state, std::size_t gaze_point) {
  NearSums sums;
  for (const GazeBody& body : state.bodies) {
    if (body.eccentricity_rad[gaze_point] >= kNear_deg * kGazeDegreeRad) continue;
    sums.add({1, body.eps2[gaze_point], elsewhere_of(body, gaze_point), body.full_eps2});
  }
  return sums;
}

NearRatio ratio_of(std::span<const NearSums> states, std::uint64_t seed) {
  NearSums all;
  for (const NearSums& state : states) all.add(state);
  NearRatio result;
  result.bodies = all.bodies;
  result.e_mps = root_mean(all.near, all.bodies);
  result.elsewhere_mps = root_mean(all.elsewhere, all.bodies);
  result.full_e_mps = root_mean(all.full, all.bodies);
  if (!(all.elsewhere > 0)) return result;
  result.ratio = std::sqrt(all.near / all.elsewhere);
  std::mt19937_64 bits(seed);
  std::vector<double> ratios;
  for (int draw = 0; draw < io::kBootstrapDraws; ++draw) {
    NearSums drawn;
    // The distributions of the standard library differ from one library to the next.
    for (std::size_t i = 0; i < states.size(); ++i) drawn.add(states[bits() % states.size()]);
    if (drawn.elsewhere > 0) ratios.push_back(std::sqrt(drawn.near / drawn.elsewhere));
  }
  constexpr double kTail = 0.025;
  result.low = simulation::percentile(ratios, kTail);
  result.high = simulation::percentile(ratios, 1 - kTail);
  return result;
}

double mean_value(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double before_of(std::span<const double> values) {
  const std::size_t half = values.size() / 2;
  return mean_value(values.subspan(half - kBeforeFrames, kBeforeFrames));
}

double settled_of(std::span<const double> values) {
  return mean_value(values.subspan(values.size() / 2 + kSettledFrom));
}

}  // namespace

std::size_t bin_of(double eccentricity_rad) {
  const auto end =
      std::ranges::find_if(kBinEnds_deg, [&](double deg) { return eccentricity_rad < deg * kGazeDegreeRad; });
  return static_cast<std::size_t>(end - kBinEnds_deg.begin());
}

void PairLevels::add(const PairLevels& part) {
  level_sum += part.level_sum;
  contacts += part.contacts;
  answered += part.answered;
  pairs += part.pairs;
}

std::optional<double> PairLevels::level_mean() const {
  return contacts > 0 ? std::optional(level_sum / static_cast<double>(contacts)) : std::nullopt;
}

std::optional<double> PairLevels::answered_share() const {
  return pairs > 0 ? std::optional(static_cast<double>(answered) / static_cast<double>(pairs)) : std::nullopt;
}

std::vector<GazeBinRow> gaze_bins(std::span<const GazeState> states) {
  std::vector<GazeBinRow> rows;
  for (std::size_t point = 0; point < kGazePoints; ++point) {
    std::array<NearSums, kEccentricityBins> sums{};
    std::array<PairLevels, kEccentricityBins> levels{};
    for (const GazeState& state : states) {
      for (const GazeBody& body : state.bodies) {
        sums[bin_of(body.eccentricity_rad[point])].add(
            {1, body.eps2[point], elsewhere_of(body, point), body.full_eps2});
      }
      for (std::size_t bin = 0; bin < kEccentricityBins; ++bin) levels[bin].add(state.levels[point][bin]);
    }
    for (std::size_t bin = 0; bin < kEccentricityBins; ++bin) {
      const NearSums& of = sums[bin];
      rows.push_back({point, bin, of.bodies, root_mean(of.near, of.bodies), root_mean(of.full, of.bodies),
                      root_mean(of.elsewhere, of.bodies), levels[bin]});
    }
  }
  return rows;
}

std::vector<NearRatio> near_ratios(std::span<const GazeState> states, std::uint64_t seed) {
  std::vector<NearRatio> ratios;
  std::vector<NearSums> all(states.size());
  for (std::size_t point = 0; point < kGazePoints; ++point) {
    std::vector<NearSums> sums;
    for (std::size_t i = 0; i < states.size(); ++i) {
      sums.push_back(sums_of(states[i], point));
      all[i].add(sums.back());
    }
    ratios.push_back(ratio_of(sums, seed));
    ratios.back().gaze_point = point;
  }
  ratios.push_back(ratio_of(all, seed));
  return ratios;
}

std::vector<std::optional<double>> gaze_cells(std::span<const GazeState> states, std::size_t gaze_point) {
  std::vector<double> sums(kCellsAcross * kCellsDown, 0);
  std::vector<std::uint64_t> counts(sums.size(), 0);
  for (const GazeState& state : states) {
    for (const GazeBody& body : state.bodies) {
      sums[body.cell] += body.eps2[gaze_point];
      ++counts[body.cell];
    }
  }
  std::vector<std::optional<double>> cells(sums.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (counts[i] >= kLeastInCell) cells[i] = root_mean(sums[i], counts[i]);
  }
  return cells;
}

std::optional<std::uint64_t> served_frame(std::span<const double> values) {
  const double before = before_of(values);
  const double settled = settled_of(values);
  if (!(settled > before)) return std::nullopt;
  const std::span<const double> after = values.subspan(values.size() / 2);
  const double enough = before + kServed * (settled - before);
  // There is one, since their mean from the tenth on is larger.
  const auto at = std::ranges::find_if(after, [&](double value) { return value >= enough; });
  return static_cast<std::uint64_t>(at - after.begin());
}

std::vector<double> mean_over_jumps(std::span<const GazeJump> jumps, std::vector<PairLevels> GazeJump::*where,
                                    PairFigure figure) {
  std::vector<double> means(jumps.empty() ? 0 : (jumps.front().*where).size(), 0);
  for (std::size_t frame = 0; frame < means.size(); ++frame) {
    std::size_t count = 0;
    for (const GazeJump& jump : jumps) {
      const std::optional<double> value = ((jump.*where)[frame].*figure)();
      if (!value) continue;
      means[frame] += *value;
      ++count;
    }
    if (count > 0) means[frame] /= static_cast<double>(count);
  }
  return means;
}

ServedFigures served_figures(std::span<const GazeJump> jumps, PairFigure figure) {
  ServedFigures result;
  if (jumps.empty()) return result;
  const std::vector<double> mean = mean_over_jumps(jumps, &GazeJump::at_new, figure);
  result.of_mean = served_frame(mean);
  result.before = before_of(mean);
  result.settled = settled_of(mean);
  std::vector<double> frames;
  for (std::size_t i = 0; i < jumps.size(); ++i) {
    const std::optional<std::uint64_t> served =
        served_frame(mean_over_jumps(jumps.subspan(i, 1), &GazeJump::at_new, figure));
    if (!served) {
      ++result.without_rise;
      continue;
    }
    ++result.jumps;
    if (*served <= kSoon) ++result.within_three;
    frames.push_back(static_cast<double>(*served));
  }
  if (frames.empty()) return result;
  result.median = simulation::percentile(frames, 0.5);
  result.largest = *std::ranges::max_element(frames);
  return result;
}

}  // namespace poise::app
