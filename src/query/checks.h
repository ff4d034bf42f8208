// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "poise/queries.h"
#include "poise/result.h"

/// Checks of query arguments: the refusal with field, value and rule, or nothing.
namespace poise::query {

inline constexpr double kMaxLengthM = 1e12;

std::optional<Error> check(const Ray& ray);
std::optional<Error> check(const SphereCast& cast);
std::optional<Error> check(const OrientedBox& box);
std::optional<Error> check_point(const char* field, const Vec3& point_m);
std::optional<Error> check_length(const char* field, double length_m);
std::optional<Error> check_distance(double max_distance_m);

}  // namespace poise::query
