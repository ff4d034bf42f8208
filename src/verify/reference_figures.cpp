// SPDX-License-Identifier: MIT
#include "verify/reference_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "frame/view_cues.h"

namespace poise::simulation {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFullSizeRad = 1.0 * kDegree;
constexpr double kHalfAcuityRad = 2.5 * kDegree;
constexpr double kHidden = 0.25;
constexpr double kOutside = 0.05;
// Minimum viewing distance, as for the cues: nothing appears larger when nearer than this.
constexpr double kNearestDistanceM = 0.05;

double squared_speed(const Vec3& v, const Vec3& w, const Mat3& inertia_per_mass_m2) {
  return v.squaredNorm() + w.dot(inertia_per_mass_m2 * w);
}

void measure_bodies(std::span<const ComparedBody> bodies, ReferenceFigures& figures) {
  figures.bodies_touched = bodies.size();
  if (bodies.empty()) return;
  double error2 = 0;
  double change2 = 0;
  double seen2 = 0;
  double weights = 0;
  for (const ComparedBody& body : bodies) {
    const double eps2 = squared_error_m2ps2(body);
    error2 += eps2;
    change2 += squared_speed(body.reference_dv_mps, body.reference_dw_radps, body.inertia_per_mass_m2);
    seen2 += body.weight * eps2;
    weights += body.weight;
  }
  const auto count = static_cast<double>(bodies.size());
  figures.e_mps = std::sqrt(error2 / count);
  figures.change_mps = std::sqrt(change2 / count);
  if (change2 > 0) figures.e_rel = std::sqrt(error2 / change2);
  if (weights > 0) figures.e_seen_mps = std::sqrt(seen2 / weights);
}

void measure_gaps(std::span<const ComparedPair> pairs, double least_ns, bool view, ReferenceFigures& figures) {
  double sum_m = 0, most_m = 0, sum_px = 0, most_px = 0;
  for (const ComparedPair& pair : pairs) {
    if (!counts_as_touch(pair.run_ns, least_ns) || !(pair.gap_m > 0)) continue;
    ++figures.contacts_apart;
    sum_m += pair.gap_m;
    sum_px += pair.gap_px;
    most_m = std::max(most_m, pair.gap_m);
    most_px = std::max(most_px, pair.gap_px);
  }
  if (figures.contacts_apart == 0) return;
  const auto count = static_cast<double>(figures.contacts_apart);
  figures.gap_mean_m = sum_m / count;
  figures.gap_max_m = most_m;
  if (!view) return;
  figures.gap_mean_px = sum_px / count;
  figures.gap_max_px = most_px;
}

}  // namespace

double least_impulse_ns(std::span<const ComparedPair> pairs) {
  double largest = 0;
  for (const ComparedPair& pair : pairs) largest = std::max({largest, pair.run_ns, pair.reference_ns});
  return kNoImpulse * largest;
}

double squared_error_m2ps2(const ComparedBody& body) {
  return squared_speed(body.dv_mps - body.reference_dv_mps, body.dw_radps - body.reference_dw_radps,
                       body.inertia_per_mass_m2);
}

double error_weight(const View& view, const Vec3& center_m, double radius_m, bool hidden) {
  if (!view.present) return 1;
  const Vec3 ray = center_m - view.position_m;
  const double distance = ray.norm();
  const double size_rad = distance > radius_m ? 2 * std::asin(radius_m / distance) : std::numbers::pi;
  const double along = distance > 0 ? std::clamp(ray.dot(view.gaze) / distance, -1.0, 1.0) : 1.0;
  const double eccentricity = std::acos(along) / kHalfAcuityRad;
  double visible = kOutside;
  if (in_frustum(view, center_m, radius_m)) visible = hidden ? kHidden : 1.0;
  const double size = size_rad / kFullSizeRad;
  return visible * std::min(1.0, size * size) / ((1 + eccentricity) * (1 + eccentricity));
}

double length_px(const View& view, const Vec3& point_m, double length_m) {
  const double distance = std::max(kNearestDistanceM, (point_m - view.position_m).norm());
  return length_m * kPictureHeightPx / (2 * distance * std::tan(0.5 * view.vertical_fov_rad));
}

ReferenceFigures compare_frames(std::span<const ComparedBody> bodies, std::span<const ComparedPair> pairs, bool view) {
  ReferenceFigures figures;
  measure_bodies(bodies, figures);
  const double least_ns = least_impulse_ns(pairs);
  for (const ComparedPair& pair : pairs) {
    const bool run = counts_as_touch(pair.run_ns, least_ns);
    const bool reference = counts_as_touch(pair.reference_ns, least_ns);
    if (run) ++figures.run_contacts;
    if (reference) ++figures.reference_contacts;
    if (run && !reference) ++figures.false_contacts;
    if (reference && !run) ++figures.missed_contacts;
  }
  const auto rate = [](std::size_t part, std::size_t whole) -> std::optional<double> {
    if (whole == 0) return std::nullopt;
    return static_cast<double>(part) / static_cast<double>(whole);
  };
  figures.false_rate = rate(figures.false_contacts, figures.run_contacts);
  figures.missed_rate = rate(figures.missed_contacts, figures.reference_contacts);
  measure_gaps(pairs, least_ns, view, figures);
  return figures;
}

}  // namespace poise::simulation
