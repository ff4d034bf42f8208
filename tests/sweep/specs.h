// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sweep/sweep_spec.h"
#include "sweep/trial.h"

namespace poise::testing {

/// The refusals of a specification, one a line; `accepted` for none.
inline std::string spec_refusals(const std::string& text) {
  std::vector<std::string> errors;
  const Result<sweep::SweepSpec> spec = sweep::parse_spec(text, "s.json", ".", errors);
  if (spec) return "accepted";
  std::string all;
  for (const std::string& error : errors) all += error + "\n";
  return all;
}

/// A specification that must be accepted.
inline sweep::SweepSpec spec_of(const nlohmann::ordered_json& json) {
  std::vector<std::string> errors;
  Result<sweep::SweepSpec> spec = sweep::parse_spec(json.dump(), "s.json", ".", errors);
  return spec ? std::move(spec).value() : sweep::SweepSpec{};
}

/// Two scenes, 2 x 2 values, 2 repeats.
inline nlohmann::ordered_json small_spec() {
  return {{"schema", "poise.sweep/1"},
          {"scenes", {"a", "b"}},
          {"settings", {{"frames", 10}, {"clock", "work"}}},
          {"axes", {{"bodies", {10, 20}}, {"budget_work", {100, 200}}}},
          {"repeats", 2}};
}

inline std::vector<sweep::SceneFile> small_scenes() { return {{"a", "/a.json", "hash a"}, {"b", "/b.json", "hash b"}}; }

}  // namespace poise::testing
