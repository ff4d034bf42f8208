// SPDX-License-Identifier: MIT
#include "app/live/live_message.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "assets/json/json_document.h"
#include "scene/field_reader.h"
#include "scene/run/policy_name.h"

namespace poise::app {
namespace {

using io::JsonValue;
using io::ObjectReader;
using io::Problems;

const char* const kName = "message";
constexpr io::Range kPart{-1, 1, false};
/// How far a direction may be from unit length: that of one in single precision is nearer.
constexpr double kUnitError = 1e-3;

void read_direction(const ObjectReader& reader, std::string_view key, Vec3& target) {
  const JsonValue* const given = reader.require(key);
  if (given == nullptr) return;
  const io::SoundSoFar sound(reader.problems());
  Vec3 direction = Vec3::Zero();
  reader.vec3(key, kPart, direction);
  if (!sound) return;
  if (std::abs(direction.norm() - 1) > kUnitError) {
    reader.problems().refuse(reader.path(key), *given, "must have length 1");
  } else {
    target = direction.normalized();
  }
}

View read_camera(const JsonValue& value, Problems& problems) {
  constexpr double kLeastAspect = 0.01, kMostAspect = 100;
  // A little more than a step asks of a view, which refuses a picture of half a turn, and 1.4 mrad between directions.
  constexpr double kMostFovRad = 3.14, kLeastSine = 2e-3;
  const ObjectReader reader(value, "camera", problems, {"position_m", "forward", "up", "vertical_fov_rad", "aspect"});
  View view;
  view.present = true;
  const io::SoundSoFar sound(problems);
  if (reader.require("position_m") != nullptr) reader.vec3("position_m", io::kAnyQuantity, view.position_m);
  read_direction(reader, "forward", view.forward);
  read_direction(reader, "up", view.up);
  reader.require_number("vertical_fov_rad", {0, kMostFovRad, true}, view.vertical_fov_rad);
  reader.require_number("aspect", {kLeastAspect, kMostAspect, false}, view.aspect);
  if (sound && view.forward.cross(view.up).norm() < kLeastSine)
    problems.refuse("camera.up", "must not be parallel to camera.forward");
  view.gaze = view.forward;
  return view;
}

LiveMessage read_deadline(const JsonValue& root, Problems& problems) {
  const ObjectReader reader(root, "", problems, {"do", "ms"});
  SetDeadline made;
  reader.require_number("ms", {0, kLongestDeadlineMs, true}, made.ms);
  return made;
}

LiveMessage read_alpha(const JsonValue& root, Problems& problems) {
  constexpr io::Range kAlpha{1e-5, 0.5, false};
  const ObjectReader reader(root, "", problems, {"do", "value"});
  SetAlpha made;
  reader.require_number("value", kAlpha, made.value);
  return made;
}

LiveMessage read_weight(const JsonValue& root, Problems& problems) {
  const ObjectReader reader(root, "", problems, {"do", "cue", "value"});
  std::vector<std::string_view> names;
  for (const scheduler::PolicyField& field : scheduler::policy_weights()) names.push_back(field.name);
  std::size_t which = names.size();
  SetWeight made;
  if (reader.require("cue") != nullptr) reader.one_of("cue", names, which);
  if (which == names.size()) return made;
  const scheduler::PolicyField& field = scheduler::policy_weights()[which];
  made.weight = field.value;
  reader.require_number("value", {field.least, field.most, false}, made.value);
  return made;
}

LiveMessage read_policy(const JsonValue& root, Problems& problems) {
  const ObjectReader reader(root, "", problems, {"do", "name"});
  std::size_t which = 0;
  if (reader.require("name") != nullptr)
    reader.one_of("name", {io::kPolicyNames.begin(), io::kPolicyNames.end()}, which);
  return SetPolicy{io::kPolicies[which].kind};
}

template <class Message>
LiveMessage read_count(const JsonValue& root, std::uint64_t least, std::uint64_t most, Problems& problems) {
  const ObjectReader reader(root, "", problems, {"do", "count"});
  Message made;
  reader.require_whole("count", least, most, made.count);
  return made;
}

LiveMessage read_view(const JsonValue& root, Problems& problems) {
  const ObjectReader reader(root, "", problems, {"do", "camera", "gaze"});
  SetView made;
  const auto is_null = [](const JsonValue& value) { return value.kind() == JsonValue::Kind::Null; };
  if (const JsonValue* camera = reader.find("camera")) {
    made.camera.emplace();
    if (!is_null(*camera)) *made.camera = read_camera(*camera, problems);
  }
  if (const JsonValue* gaze = reader.find("gaze")) {
    made.gaze.emplace();
    Vec3 direction = Vec3::UnitX();
    if (!is_null(*gaze)) {
      read_direction(reader, "gaze", direction);
      *made.gaze = direction;
    }
  }
  return made;
}

LiveMessage read_paused(const JsonValue& root, Problems& problems) {
  const ObjectReader reader(root, "", problems, {"do", "on"});
  SetPaused made;
  reader.require_flag("on", made.on);
  return made;
}

LiveMessage read_again(const JsonValue& root, Problems& problems) {
  const ObjectReader reader(root, "", problems, {"do"});
  return StartAgain{};
}

LiveMessage read_shown(const JsonValue& root, Problems& problems) {
  const ObjectReader reader(root, "", problems, {"do", "number"});
  FrameShown made;
  reader.require_whole("number", 0, std::numeric_limits<std::uint64_t>::max(), made.number);
  return made;
}

struct Kind {
  std::string_view name;
  LiveMessage (*read)(const JsonValue& root, Problems& problems);
};

constexpr Kind kKinds[] = {
    {"deadline", read_deadline},
    {"alpha", read_alpha},
    {"weight", read_weight},
    {"policy", read_policy},
    {"bodies", [](const JsonValue& root,
                  Problems& problems) { return read_count<SetBodies>(root, 0, kMostLiveBodies, problems); }},
    {"pour",
     [](const JsonValue& root, Problems& problems) { return read_count<PourBodies>(root, 1, kMostPoured, problems); }},
    {"view", read_view},
    {"pause", read_paused},
    {"step",
     [](const JsonValue& root, Problems& problems) { return read_count<StepFrames>(root, 1, kMostSteps, problems); }},
    {"again", read_again},
    {"shown", read_shown},
};

}  // namespace

Result<LiveMessage> parse_live_message(std::string_view text) {
  if (text.size() > kMostMessageBytes)
    return bad_input(fmt::format("{}: {} bytes, must be at most {}", kName, text.size(), kMostMessageBytes));
  const Result<JsonValue> root = io::parse_json(text, kName);
  if (!root) return root.error();
  Problems problems(kName);
  std::vector<std::string_view> names;
  for (const Kind& kind : kKinds) names.push_back(kind.name);
  std::size_t which = names.size();
  if (root.value().kind() != JsonValue::Kind::Object) {
    problems.refuse("", fmt::format("must be an object, is {}", io::shown(root.value())));
  } else if (const JsonValue* asked = root.value().find("do"); asked == nullptr) {
    problems.refuse("do", "missing, and it is required");
  } else {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (asked->kind() == JsonValue::Kind::String && asked->text() == names[i]) which = i;
    }
    if (which == names.size()) problems.refuse("do", *asked, "must be " + io::listed(names));
  }
  if (which == names.size()) return *problems.first();
  LiveMessage message = kKinds[which].read(root.value(), problems);
  if (problems.count() > 0) return *problems.first();
  return message;
}

}  // namespace poise::app
