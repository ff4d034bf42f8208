// SPDX-License-Identifier: MIT
#include "world/validation.h"

#include <fmt/format.h>

#include <cmath>

namespace poise::simulation {

std::optional<Error> check_range(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return std::nullopt;
  return bad_input(fmt::format("{} = {}, must be in [{}, {}]", field, value, least, most));
}

namespace {

// A value of an enumeration that a caller may have made from any number.
template <class Choice>
std::optional<Error> check_choice(const char* field, Choice value, Choice last) {
  return check_range(field, static_cast<int>(value), 0, static_cast<int>(last));
}

}  // namespace

std::optional<Error> check_vector(const char* field, const Vec3& value, double most) {
  if (value.allFinite() && value.cwiseAbs().maxCoeff() <= most) return std::nullopt;
  return bad_input(fmt::format("{} = [{}, {}, {}], each must be finite and within {} of zero", field, value.x(),
                               value.y(), value.z(), most));
}

Error stale_body(BodyId body) {
  return {ErrorKind::StaleHandle, fmt::format("body {}.{} does not exist", body.slot, body.generation)};
}

std::optional<Error> check_settings(const WorldSettings& settings) {
  // Beyond these a quantile of frames says nothing.
  constexpr double kLeastAlpha = 1e-5;
  constexpr double kMostAlpha = 0.5;
  if (auto bad = check_vector("gravity_mps2", settings.gravity_mps2, kMaxAccelerationMps2)) return bad;
  if (const auto problem = scheduler::first_problem(settings.policy))
    return bad_input("policy." + scheduler::text_of(*problem));
  if (auto bad = check_choice("executor", settings.executor, ExecutorKind::Host)) return bad;
  if (auto bad = check_choice("contact", settings.contact, ContactModel::Fitted)) return bad;
  if (auto bad = check_choice("islands_wait", settings.islands_wait, IslandsWait::Any)) return bad;
  if (auto bad = check_range("threads", settings.threads, 0, 256)) return bad;
  if (auto bad = check_range("substeps", settings.substeps, 1, 16)) return bad;
  if (auto bad = check_range("alpha", settings.alpha, kLeastAlpha, kMostAlpha)) return bad;
  if (auto bad = check_range("max_partners", settings.max_partners, 1, 65536)) return bad;
  if (auto bad = check_range("max_pairs", settings.max_pairs, 1024, 1U << 28U)) return bad;
  return check_range("max_front_entries", settings.max_front_entries, 64, 1U << 26U);
}

std::optional<Error> check_state(const BodyState& state, bool is_static) {
  if (auto bad = check_vector("position_m", state.position_m, kMaxPositionM)) return bad;
  const Quat& q = state.orientation;
  const double norm = q.norm();
  if (!std::isfinite(norm) || !(norm > 1e-9)) {
    return bad_input(fmt::format("orientation_wxyz = [{}, {}, {}, {}], must be finite, with a norm above 1e-9", q.w(),
                                 q.x(), q.y(), q.z()));
  }
  if (auto bad = check_vector("velocity_mps", state.velocity_mps, kMaxSpeedMps)) return bad;
  if (auto bad = check_vector("angular_velocity_radps", state.angular_velocity_radps, kMaxSpinRadps)) return bad;
  if (!is_static) return std::nullopt;
  if (!state.velocity_mps.isZero(0)) return bad_input("velocity_mps: a static body must be at rest");
  if (!state.angular_velocity_radps.isZero(0)) {
    return bad_input("angular_velocity_radps: a static body must be at rest");
  }
  return std::nullopt;
}

std::optional<Error> check_body(const BodyDefinition& definition, const Shape& shape) {
  if (auto bad = check_choice("motion", definition.motion, MotionType::Dynamic)) return bad;
  if (shape.kind == ShapeKind::Plane && definition.motion != MotionType::Static)
    return bad_input("motion: a plane must be static");
  if (auto bad = check_state(
          {definition.position_m, definition.orientation, definition.velocity_mps, definition.angular_velocity_radps},
          definition.motion == MotionType::Static)) {
    return bad;
  }
  if (auto bad = check_range("importance", definition.importance, 0, kMaxImportance)) return bad;
  if (definition.mass_kg != 0) {
    if (!(definition.mass_kg > 0)) {
      return bad_input(fmt::format("mass_kg = {}, must be > 0", definition.mass_kg));
    }
    if (auto bad = check_range("mass_kg", definition.mass_kg, kMinMassKg, kMaxMassKg)) return bad;
  }
  const Vec3& inertia = definition.inertia_kgm2;
  if (inertia.isZero(0)) return std::nullopt;
  if (!inertia.allFinite() || !(inertia.minCoeff() > 0)) {
    return bad_input(
        fmt::format("inertia_kgm2 = [{}, {}, {}], each must be finite and > 0", inertia.x(), inertia.y(), inertia.z()));
  }
  // No mass distribution has a principal moment above the sum of the other two.
  const double largest = inertia.maxCoeff();
  if (largest > (inertia.sum() - largest) * (1.0 + 1e-9)) {
    return bad_input(
        fmt::format("inertia_kgm2 = [{}, {}, {}], the largest must be <= the sum of the others (triangle inequality)",
                    inertia.x(), inertia.y(), inertia.z()));
  }
  return std::nullopt;
}

Result<BodyMass> mass_of(const BodyDefinition& definition, const Shape& shape, double density_kgpm3) {
  BodyMass mass;
  if (definition.motion != MotionType::Dynamic) return mass;
  mass.mass_kg = definition.mass_kg != 0 ? definition.mass_kg : density_kgpm3 * shape.volume_m3;
  if (auto bad = check_range("mass from density and volume, mass_kg", mass.mass_kg, kMinMassKg, kMaxMassKg))
    return *bad;
  mass.principal_kgm2 = definition.inertia_kgm2;
  if (definition.inertia_kgm2.isZero(0)) mass.principal_kgm2 = shape.principal_m5 * (mass.mass_kg / shape.volume_m3);
  if (!mass.principal_kgm2.allFinite() || !(mass.principal_kgm2.minCoeff() > 1e-60) ||
      mass.principal_kgm2.maxCoeff() > 1e60) {
    return bad_input("inertia_kgm2: what shape and mass give is not a positive finite inertia");
  }
  const double least_kgm2 = kLeastOfInertia * mass.mass_kg * shape.bounding_radius_m * shape.bounding_radius_m;
  if (mass.principal_kgm2.minCoeff() < least_kgm2) {
    const Vec3& inertia = mass.principal_kgm2;
    return bad_input(fmt::format(
        "inertia_kgm2 = [{}, {}, {}], each must be >= {} (the mass times the square of the bounding radius, times {})",
        inertia.x(), inertia.y(), inertia.z(), least_kgm2, kLeastOfInertia));
  }
  return mass;
}

}  // namespace poise::simulation
