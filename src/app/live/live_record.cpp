// SPDX-License-Identifier: MIT
#include "app/live/live_record.h"

#include <nlohmann/json.hpp>
#include <span>

#include "scene/run/policy_name.h"
#include "scene/run/run_report.h"

namespace poise::app {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

std::string status_json(const LiveStatus& status, std::uint64_t frames_dropped, std::size_t browsers) {
  Json weights = Json::object();
  for (const scheduler::PolicyField& field : scheduler::policy_weights()) {
    weights[std::string(field.name)] = {
        {"value", status.policy.*field.value}, {"least", field.least}, {"most", field.most}};
  }
  Json recent = Json::object();
  std::uint64_t frames = 0;
  for (std::size_t cause = 0; cause < status.recent.size(); ++cause) {
    frames += status.recent[cause];
    if (cause > 0) recent[simulation::cause_name(static_cast<MissCause>(cause))] = status.recent[cause];
  }
  const Json policies(std::vector<std::string>(io::kPolicyNames.begin(), io::kPolicyNames.end()));
  return text_of({{"status",
                   {{"deadline_ms", status.deadline_ms},
                    {"alpha", status.alpha},
                    {"policy", io::policy_name(status.policy.kind)},
                    {"policies", policies},
                    {"weights", weights},
                    {"paused", status.paused},
                    {"bodies", status.bodies},
                    {"bodies_asked", status.bodies_asked},
                    {"bodies_most", kMostLiveBodies},
                    {"frame", status.frame},
                    {"recent_frames", frames},
                    {"late", recent},
                    {"speed", status.speed},
                    {"frames_a_step", status.frames_a_step},
                    {"left_out", status.left_out},
                    {"dropped", frames_dropped},
                    {"browsers", browsers}}}});
}

std::string error_json(const std::string& error) { return text_of({{"error", error}}); }

}  // namespace poise::app
