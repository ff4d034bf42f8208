// SPDX-License-Identifier: MIT
#include "soak/soak_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "soak/counted_memory.h"

namespace poise::soak {
namespace {

constexpr double kMib = 1048576;

// Chosen. A frame with more contacts than any before it may make the list of pairs twice as long, and with it a dozen
// lists of the pairs of bodies that wait or sleep: 10 MiB with 1,200 bodies, hardly any of it touched.
constexpr std::uint64_t kHeapMayGrow = 16U << 20U, kOfEachBody = 1024;
constexpr std::uint64_t kLeastWarmUp = 4;
/// A leak grows in every cycle, lists do not: what counts as growth of a cycle, and the share of cycles without it.
constexpr std::uint64_t kGrows = 4096;
constexpr double kCyclesWithout = 0.125;
// The system gives pages when they are first touched, and takes them as it likes.
constexpr std::uint64_t kResidentMayGrow = 32U << 20U;
/// Frames in which a list may still grow after the warm-up, as crowds differ from cycle to cycle: so many, and this
/// share. Chosen.
constexpr double kFirstMayAllocate = 32, kFramesMayAllocate = 0.001;
/// Of the medians of the last third to those of the first, on a machine that others use too. Chosen.
constexpr double kForecastMayDrift = 1.5;
constexpr std::size_t kCyclesOfForecast = 9;

template <class Value>
double mean(std::span<const CycleFigures> cycles, Value value) {
  double sum = 0;
  for (const CycleFigures& cycle : cycles) sum += value(cycle);
  return sum / static_cast<double>(std::max<std::size_t>(cycles.size(), 1));
}

/// How much the largest of the later values is above the first.
template <class Value>
std::uint64_t growth(std::span<const CycleFigures> cycles, Value value) {
  std::uint64_t most = 0;
  for (const CycleFigures& cycle : cycles)
    most = std::max(most, value(cycle) - std::min(value(cycle), value(cycles.front())));
  return most;
}

Check memory_check(const char* name, std::uint64_t grown, std::uint64_t may_grow, std::uint64_t from) {
  return {name, grown <= may_grow,
          fmt::format("{:.2f} MiB above the {:.1f} MiB after the warm-up", static_cast<double>(grown) / kMib,
                      static_cast<double>(from) / kMib),
          fmt::format("{:.2f} MiB", static_cast<double>(may_grow) / kMib)};
}

Check leak_check(std::span<const CycleFigures> cycles) {
  std::uint64_t grew = 0;
  for (std::size_t i = 1; i < cycles.size(); ++i)
    grew += static_cast<std::uint64_t>(cycles[i].heap_bytes > cycles[i - 1].heap_bytes + kGrows);
  const auto of = static_cast<double>(cycles.size() - 1);
  const double most = std::min(of - 1, (1 - kCyclesWithout) * of);
  return {"leak", static_cast<double>(grew) <= most,
          fmt::format("the heap grew by more than {} bytes in {} of {} cycles", kGrows, grew, cycles.size() - 1),
          fmt::format("{:g}", std::floor(most))};
}

Check forecast_check(std::span<const CycleFigures> cycles) {
  if (cycles.size() < kCyclesOfForecast)
    return {"forecast", true, fmt::format("not told of {} cycles", cycles.size()),
            fmt::format("{} cycles", kCyclesOfForecast)};
  const auto ratio = [](const CycleFigures& cycle) { return cycle.ratio; };
  const double first = mean(cycles.first(cycles.size() / 3), ratio);
  const double last = mean(cycles.last(cycles.size() / 3), ratio);
  return {"forecast", last / first < kForecastMayDrift && first / last < kForecastMayDrift,
          fmt::format("tail / forecast {:.3f} in the first third, {:.3f} in the last", first, last),
          fmt::format("a factor of {}", kForecastMayDrift)};
}

}  // namespace

std::uint64_t usual_warm_up(std::uint64_t cycles) { return std::max(kLeastWarmUp, cycles / 3); }

void SoakFigures::add(const SoakFrame& frame) {
  const FrameReport& report = frame.report;
  if (!frame.same && other_states_++ == 0) first_other_ = frames_;
  if (!std::isfinite(report.kinetic_j) || !std::isfinite(report.potential_j)) ++not_finite_;
  if (frame.allocations > 0) ++now_.frames_that_allocated;
  if (report.lateness.count() > 0) ++now_.late;
  if (report.tail_forecast.count() > 0 && report.tail_needed().count() > 0) {
    ++now_.forecast;
    if (report.tail_needed() <= report.reserve_at_cut) ++now_.covered;
    const double ratio =
        static_cast<double>(report.tail_needed().count()) / static_cast<double>(report.tail_forecast.count());
    const double bin = (std::log2(ratio) + kOctaves / 2) * kBinsOfOctave;
    ++ratios_[static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(ratios_.size() - 1)))];
  }
  if (++frames_ % kCycle != 0) return;
  std::uint64_t below = 0;
  std::size_t bin = 0;
  while (bin + 1 < ratios_.size() && 2 * (below += ratios_[bin]) < now_.forecast) ++bin;
  now_.ratio = std::exp2((static_cast<double>(bin) + 0.5) / kBinsOfOctave - kOctaves / 2);
  now_.heap_bytes = heap_bytes();
  now_.resident_bytes = resident_bytes();
  cycles_.push_back(now_);
  now_ = {};
  ratios_.fill(0);
}

std::vector<Check> SoakFigures::checks(std::uint64_t warm_up, const SoakCounts& counts) const {
  std::vector<Check> checks;
  checks.push_back({"replay", other_states_ == 0 && frames_ > 0,
                    other_states_ == 0 ? fmt::format("the same state after each of {} frames", frames_)
                                       : fmt::format("another state, first after frame {}", first_other_),
                    "none differs"});
  checks.push_back({"stale handles", counts.stale_accepted == 0 && counts.stale_asked > 0,
                    fmt::format("{} of {} calls accepted", counts.stale_accepted, counts.stale_asked), "none"});
  checks.push_back(
      {"slots", counts.recycled > 0 && counts.slots <= counts.most_at_once + 64,
       fmt::format("{} for {} bodies, of whom {} were there at once", counts.slots, counts.added, counts.most_at_once),
       "64 more than bodies at once"});
  checks.push_back(
      {"finite", not_finite_ == 0 && counts.out_of_range == 0,
       fmt::format("{} frames without finite energy, {} bodies out of range", not_finite_, counts.out_of_range),
       "none"});
  if (cycles_.size() < warm_up + 3) {
    checks.push_back(
        {"memory", false, fmt::format("{} cycles", cycles_.size()), fmt::format("at least {}", warm_up + 3)});
    return checks;
  }
  // The last one of the warm-up is what the others are compared with.
  const std::span<const CycleFigures> compared = std::span(cycles_).subspan(warm_up == 0 ? 0 : warm_up - 1);
  const auto heap = [](const CycleFigures& cycle) { return cycle.heap_bytes; };
  const auto resident = [](const CycleFigures& cycle) { return cycle.resident_bytes; };
  checks.push_back(memory_check("heap", growth(compared, heap), kHeapMayGrow + kOfEachBody * counts.most_at_once,
                                compared.front().heap_bytes));
  // Within the warm-up too: a list that is too short is made twice as long.
  const std::span<const CycleFigures> all =
      std::span(cycles_).subspan(std::min<std::size_t>(warm_up, kLeastWarmUp) - (warm_up == 0 ? 0 : 1));
  checks.push_back(memory_check("heap at any time", growth(all, heap), all.front().heap_bytes, all.front().heap_bytes));
  checks.push_back(leak_check(compared));
  checks.push_back(
      memory_check("resident memory", growth(compared, resident), kResidentMayGrow, compared.front().resident_bytes));
  const std::span<const CycleFigures> after = std::span(cycles_).subspan(warm_up);
  std::uint64_t allocated = 0;
  for (const CycleFigures& cycle : after) allocated += cycle.frames_that_allocated;
  const double most = std::floor(kFirstMayAllocate + kFramesMayAllocate * static_cast<double>(after.size() * kCycle));
  checks.push_back({"allocations", static_cast<double>(allocated) <= most,
                    fmt::format("in {} of {} frames, {} in the last cycle", allocated, after.size() * kCycle,
                                after.back().frames_that_allocated),
                    fmt::format("{:g}", most)});
  checks.push_back(forecast_check(after));
  return checks;
}

}  // namespace poise::soak
