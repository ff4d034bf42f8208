// SPDX-License-Identifier: MIT
#include "scene/run/reference_run.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

namespace poise::simulation {
namespace {

/// Percentiles of `value` over the frames in which it is defined.
template <class Value>
std::optional<Percentiles> over(std::span<const ReferenceFigures> frames, Value&& value) {
  std::vector<double> values;
  for (const ReferenceFigures& frame : frames) {
    const std::optional<double> one = value(frame);
    if (one) values.push_back(*one);
  }
  if (values.empty()) return std::nullopt;
  return percentiles(std::move(values));
}

std::optional<double> share(std::uint64_t part, std::uint64_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

std::optional<double> scaled(const std::optional<double>& value, double factor) {
  if (!value) return std::nullopt;
  return factor * *value;
}

}  // namespace

ReferenceRunFigures reference_run_figures(std::span<const ReferenceFigures> all) {
  ReferenceRunFigures figures;
  figures.frames = all.size();
  std::vector<ReferenceFigures> frames;
  std::copy_if(all.begin(), all.end(), std::back_inserter(frames),
               [](const ReferenceFigures& frame) { return frame.converged; });
  figures.not_converged = all.size() - frames.size();
  for (const ReferenceFigures& frame : all) figures.pairs_not_finest += frame.pairs_not_finest;
  for (const ReferenceFigures& frame : frames) {
    figures.run_contacts += frame.run_contacts;
    figures.reference_contacts += frame.reference_contacts;
    figures.false_contacts += frame.false_contacts;
    figures.missed_contacts += frame.missed_contacts;
    figures.contacts_apart += frame.contacts_apart;
  }
  figures.false_share = share(figures.false_contacts, figures.run_contacts);
  figures.missed_share = share(figures.missed_contacts, figures.reference_contacts);
  const auto member = [&frames](std::optional<double> ReferenceFigures::*which, double factor = 1) {
    return over(frames, [=](const ReferenceFigures& frame) { return scaled(frame.*which, factor); });
  };
  constexpr double kMmPerM = 1000;
  figures.e_mps = member(&ReferenceFigures::e_mps);
  figures.e_rel = member(&ReferenceFigures::e_rel);
  figures.e_seen_mps = member(&ReferenceFigures::e_seen_mps);
  figures.gap_mean_mm = member(&ReferenceFigures::gap_mean_m, kMmPerM);
  figures.gap_max_mm = member(&ReferenceFigures::gap_max_m, kMmPerM);
  figures.gap_mean_px = member(&ReferenceFigures::gap_mean_px);
  figures.gap_max_px = member(&ReferenceFigures::gap_max_px);
  figures.false_rate = member(&ReferenceFigures::false_rate);
  figures.missed_rate = member(&ReferenceFigures::missed_rate);
  const auto number = [all](auto&& value) {
    return over(all, [&](const ReferenceFigures& frame) { return std::optional<double>(value(frame)); });
  };
  const auto touched = [](const ReferenceFigures& f) {
    return std::optional<double>(static_cast<double>(f.bodies_touched));
  };
  figures.bodies_touched = over(frames, touched);
  figures.iterations = number([](const ReferenceFigures& f) { return static_cast<double>(f.iterations); });
  figures.time_ms = number([](const ReferenceFigures& f) { return static_cast<double>(f.time.count()) / 1e6; });
  return figures;
}

}  // namespace poise::simulation
