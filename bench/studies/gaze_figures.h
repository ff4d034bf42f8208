// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "studies/gaze_view.h"

namespace poise::app {

/// Ends of the bins of eccentricity, degrees; the last bin has no end.
inline constexpr std::array<double, 4> kBinEnds_deg{2, 5, 10, 20};
inline constexpr std::size_t kEccentricityBins = kBinEnds_deg.size() + 1;
/// What is nearer to the gaze than this is *near*, degrees.
inline constexpr double kNear_deg = 5;
/// Cells of the picture in which errors are shown.
inline constexpr std::size_t kCellsAcross = 24, kCellsDown = 14;

std::size_t bin_of(double eccentricity_rad);

/// A body of a state in the picture that was touched in the reference or in one of the steps.
struct GazeBody {
  std::uint32_t cell = 0;  ///< row by row from the top left
  std::array<double, kGazePoints> eccentricity_rad{};
  /// eps^2 in the step with the gaze at each point, m^2/s^2; 0 where neither that step nor the reference touched it.
  std::array<double, kGazePoints> eps2{};
  double full_eps2 = 0;  ///< in the step that refined everything
};

/// Levels by which contacts are answered, cached ones included, and how many pairs are answered for good.
struct PairLevels {
  double level_sum = 0;
  std::uint64_t contacts = 0;  ///< pairs that are not known to be separated
  std::uint64_t answered = 0;  ///< of all pairs: nothing was left to refine, or to refine again
  std::uint64_t pairs = 0;     ///< whose root spheres overlap

  void add(const PairLevels& part);
  [[nodiscard]] std::optional<double> level_mean() const;      ///< over the contacts
  [[nodiscard]] std::optional<double> answered_share() const;  ///< of the pairs
};

/// One state, stepped once with the gaze at each point.
struct GazeState {
  std::vector<GazeBody> bodies;
  double full_units = 0;                                                        ///< work of its full refinement
  std::array<std::array<PairLevels, kEccentricityBins>, kGazePoints> levels{};  ///< by eccentricity of the pair
};

/// A gaze point and a bin of eccentricity, over all states. Empty where there is nothing.
struct GazeBinRow {
  std::size_t gaze_point = 0, bin = 0;
  std::uint64_t bodies = 0;             ///< bodies of all states
  std::optional<double> e_mps;          ///< root of the mean eps^2
  std::optional<double> full_e_mps;     ///< the same of the steps that refined everything
  std::optional<double> elsewhere_mps;  ///< of the same bodies with the gaze at the other points
  PairLevels levels;
};
std::vector<GazeBinRow> gaze_bins(std::span<const GazeState> states);

/// Error of what is near the gaze, over that of the same bodies with the gaze at the other points: the root of the
/// quotient of the sums of eps^2 over all states, those elsewhere by half, since there are two other points.
struct NearRatio {
  std::optional<std::size_t> gaze_point;  ///< empty: all of them together
  std::uint64_t bodies = 0;               ///< near the gaze, over all states
  std::optional<double> e_mps, elsewhere_mps, full_e_mps;
  std::optional<double> ratio;  ///< empty where the error elsewhere is 0
  double low = 0, high = 0;     ///< 95 % interval: bootstrap over the states (percentiles, 2,000 draws)
};
/// One for each gaze point, then of all. The same arguments give the same bits.
std::vector<NearRatio> near_ratios(std::span<const GazeState> states, std::uint64_t seed);

/// Least number of bodies of all states in a cell whose error is shown. Chosen.
inline constexpr std::uint64_t kLeastInCell = 30;
/// Root of the mean eps^2 in each cell, m/s; empty where there are fewer bodies.
std::vector<std::optional<double>> gaze_cells(std::span<const GazeState> states, std::size_t gaze_point);

/// Frames about one jump of the gaze: as many before it as from it on.
struct GazeJump {
  std::vector<PairLevels> at_new, at_old;  ///< near the new gaze point and near the old one; the jump is in the middle
};

/// Frames on which the value before the jump and the settled one are taken. Chosen: ten before, and from the tenth on.
inline constexpr std::size_t kBeforeFrames = 10, kSettledFrom = 10;

/// The first frame, 0 being the first one with the new gaze, in which a figure of what is near the new gaze has come 90
/// % of the way from its mean over the ten frames before the jump to its mean from the tenth frame on. `values`: as
/// many frames before the jump as from it on, at least 11 each. Empty where the figure does not rise.
std::optional<std::uint64_t> served_frame(std::span<const double> values);

/// Means over jumps, one a frame, of one figure; frames in which a jump has no such pairs are left
/// out of it, and 0 where no jump has any.
using PairFigure = std::optional<double> (PairLevels::*)() const;
std::vector<double> mean_over_jumps(std::span<const GazeJump> jumps, std::vector<PairLevels> GazeJump::*where,
                                    PairFigure figure);

/// When jumps were served by one figure.
struct ServedFigures {
  std::optional<std::uint64_t> of_mean;  ///< of the mean over the jumps
  std::uint64_t jumps = 0;               ///< in which the figure rises
  std::uint64_t without_rise = 0;
  std::optional<double> median, largest;  ///< frames, over those in which it rises
  std::uint64_t within_three = 0;         ///< of these, served in frame 3 or before
  double before = 0, settled = 0;         ///< of the mean
};
ServedFigures served_figures(std::span<const GazeJump> jumps, PairFigure figure);

}  // namespace poise::app
