// SPDX-License-Identifier: MIT
#include "app/compare/serve.h"

#include <deque>
#include <istream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/compare/compare_options.h"
#include "app/compare/state_trials.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

using Json = nlohmann::ordered_json;

struct StateSet {
  std::deque<simulation::SharedReference> references;
  std::deque<StateTrials> states;
};

Status write_line(const Json& json) {
  return io::write_stdout(json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

Json error_line(const std::string& message) { return {{"error", message}}; }

Json answer(const std::string& line, const Scene& scene, const CompareSettings& settings, StateSet& set) {
  Result<Competitor> competitor = competitor_named(line, scene.policy);
  if (!competitor) return error_line(competitor.error().message);
  if (competitor.value().oracle && settings.history > 1)
    return error_line("oracle knows one frame: it cannot be asked with --history above 1");
  std::vector<std::string> errors;
  if (competitor.value().file) {
    const Status read = read_policy_file(competitor.value(), errors);
    if (!read) return error_line(read.error().message);
  }
  Json json{{"policy", competitor.value().name},
            {"E_seen", Json::array()},
            {"E", Json::array()},
            {"work_units", Json::array()}};
  for (StateTrials& state : set.states) {
    Json seen = Json::array(), error = Json::array(), work = Json::array();
    for (const double budget : settings.budgets) {
      const Result<io::ComparedStep> step = state.trial(competitor.value(), budget);
      if (!step) return error_line(step.error().message);
      const auto defined = [&](const std::optional<double>& value) {
        return step.value().converged && value ? Json(*value) : Json(nullptr);
      };
      seen.push_back(defined(step.value().e_seen_mps));
      error.push_back(defined(step.value().e_mps));
      work.push_back(step.value().work_units);
    }
    json["E_seen"].push_back(seen);
    json["E"].push_back(error);
    json["work_units"].push_back(work);
  }
  return json;
}

}  // namespace

Status serve_policies(const Scene& scene, SceneRun& run, const CompareSettings& settings,
                      const io::ComparisonDocument& facts, const StatesIdentity& identity, std::istream& in,
                      const std::function<bool(double share)>& told) {
  StateSet set;
  const auto keep = [&](std::uint64_t frame) -> Status {
    set.states.emplace_back(scene, run, settings, set.references.emplace_back(), frame);
    return Done{};
  };
  Status done = visit_states(scene, run, settings, keep, told);
  if (done) {
    done = write_line({{"schema", "poise.compare-steps/1"},
                       {"scene", facts.scene},
                       {"bodies", facts.bodies},
                       {"clock", facts.clock},
                       {"seed", facts.seed},
                       {"budgets", settings.budgets},
                       {"budget_unit", facts.budget_unit},
                       {"history", facts.history},
                       {"states", set.states.size()},
                       {"machine", facts.machine},
                       {"build", facts.build},
                       {"scene_hash", identity.scene_hash},
                       {"program", identity.program}});
  }
  for (std::string line; done && std::getline(in, line);) {
    if (!line.empty()) done = write_line(answer(line, scene, settings, set));
  }
  return done;
}

}  // namespace poise::app
