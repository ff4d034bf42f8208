// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <span>

#include "record/record_bytes.h"
#include "scene/field_reader.h"
#include "scene/run/policy_name.h"
#include "world/contact_model_names.h"

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;

// 16 hexadecimal digits: not every JSON reader preserves 64-bit numbers.
std::string hex(std::uint64_t value) { return fmt::format("{:016x}", value); }

// A record may also be of a program with a function of its own.
constexpr auto kRecordedPolicies = [] {
  std::array<NamedPolicy, kPolicies.size() + 1> all{};
  for (std::size_t i = 0; i < kPolicies.size(); ++i) all[i] = kPolicies[i];
  all.back() = {"custom", scheduler::PolicyKind::Custom};
  return all;
}();
struct ExecutorName {
  const char* name;
  ExecutorKind kind;
};
constexpr std::array kExecutors{ExecutorName{"tbb", ExecutorKind::Tbb}, ExecutorName{"threads", ExecutorKind::Threads},
                                ExecutorName{"serial", ExecutorKind::Serial}, ExecutorName{"host", ExecutorKind::Host}};

Json optional_number(const std::optional<std::uint64_t>& value) { return value ? Json(*value) : Json(nullptr); }

Json shapes_json(const std::vector<RecordedShape>& shapes) {
  Json list = Json::array();
  for (const RecordedShape& shape : shapes) {
    Json files = Json::array();
    for (const RecordedFile& file : shape.files)
      files.push_back({{"path", file.path}, {"bytes", file.bytes}, {"xxh64", hex(file.hash)}});
    list.push_back({{"name", shape.name}, {"files", files}, {"xxh64", hex(shape.hash)}});
  }
  return list;
}

Json world_json(const WorldSettings& world) {
  Json json;
  for (const simulation::NamedContactModel& named : simulation::kContactModels) {
    if (named.model == world.contact) json["contact"] = named.name;
  }
  json["policy"] = policy_name(world.policy.kind);
  for (const scheduler::PolicyField& field : scheduler::policy_weights())
    json["weights"][std::string(field.name)] = world.policy.*field.value;
  for (const scheduler::PolicyField& field : scheduler::policy_parameters())
    json["parameters"][std::string(field.name)] = world.policy.*field.value;
  for (const scheduler::PolicyCount& field : scheduler::policy_counts())
    json["parameters"][std::string(field.name)] = world.policy.*field.value;
  for (const ExecutorName& named : kExecutors) {
    if (named.kind == world.executor) json["executor"] = named.name;
  }
  json["threads"] = world.threads;
  json["sleeping"] = world.sleeping;
  json["substeps"] = world.substeps;
  json["max_partners"] = world.max_partners;
  json["max_pairs"] = world.max_pairs;
  json["max_front_entries"] = world.max_front_entries;
  return json;
}

// The entry of a list of named values that a member selects.
template <class Named>
const Named* named_in(const ObjectReader& reader, std::string_view key, std::span<const Named> names) {
  const JsonValue* value = reader.require(key);
  if (value == nullptr) return nullptr;
  for (const Named& named : names) {
    if (value->kind() == JsonValue::Kind::String && value->text() == named.name) return &named;
  }
  reader.problems().refuse(reader.path(key), *value, "must be a name that this program knows");
  return nullptr;
}

void read_hex(const ObjectReader& reader, std::string_view key, std::uint64_t& target) {
  const JsonValue* value = reader.require(key);
  if (value == nullptr) return;
  const std::string_view text = value->text();
  const auto [stop, failure] = std::from_chars(text.data(), text.data() + text.size(), target, 16);
  if (value->kind() != JsonValue::Kind::String || text.size() != 16 || failure != std::errc{} ||
      stop != text.data() + text.size()) {
    reader.problems().refuse(reader.path(key), *value, "must be 16 hexadecimal digits");
  }
}

void read_optional(const ObjectReader& reader, std::string_view key, std::optional<std::uint64_t>& target) {
  const JsonValue* value = reader.require(key);
  if (value == nullptr || value->kind() == JsonValue::Kind::Null) return;
  std::uint64_t number = 0;
  reader.whole(key, 0, UINT64_MAX, number);
  target = number;
}

// Whole numbers that JSON holds exactly everywhere.
constexpr std::uint64_t kMostFrames = std::uint64_t{1} << 53U;

void read_shape(const JsonValue& value, const std::string& path, Problems& problems, RecordedShape& shape) {
  const ObjectReader reader(value, path, problems, {"name", "files", "xxh64"});
  reader.require_text("name", shape.name);
  read_hex(reader, "xxh64", shape.hash);
  const JsonValue* files = reader.require("files");
  if (files == nullptr) return;
  if (files->kind() != JsonValue::Kind::Array) {
    problems.refuse(reader.path("files"), *files, "must be a list");
    return;
  }
  for (std::size_t i = 0; i < files->items().size(); ++i) {
    const ObjectReader file(files->items()[i], item_path(reader.path("files"), i), problems,
                            {"path", "bytes", "xxh64"});
    RecordedFile read;
    file.require_text("path", read.path);
    file.require_whole("bytes", 0, UINT64_MAX, read.bytes);
    read_hex(file, "xxh64", read.hash);
    shape.files.push_back(read);
  }
}

/// Records from before the parameters were added have only the first six weights. The others get their defaults, with
/// which those runs were made.
void read_policy(const ObjectReader& world, scheduler::Policy& policy) {
  std::vector<std::string_view> weights, parameters;
  for (const scheduler::PolicyField& field : scheduler::policy_weights()) weights.push_back(field.name);
  for (const scheduler::PolicyField& field : scheduler::policy_parameters()) parameters.push_back(field.name);
  for (const scheduler::PolicyCount& field : scheduler::policy_counts()) parameters.push_back(field.name);
  if (const JsonValue* value = world.require("weights")) {
    const ObjectReader each(*value, world.path("weights"), world.problems(), weights);
    for (const scheduler::PolicyField& field : scheduler::policy_weights())
      each.number(field.name, Range{field.least, field.most, false}, policy.*field.value);
  }
  if (const JsonValue* value = world.find("parameters")) {
    const ObjectReader each(*value, world.path("parameters"), world.problems(), parameters);
    for (const scheduler::PolicyField& field : scheduler::policy_parameters())
      each.number(field.name, Range{field.least, field.most, false}, policy.*field.value);
    for (const scheduler::PolicyCount& field : scheduler::policy_counts()) {
      std::uint64_t count = policy.*field.value;
      each.whole(field.name, field.least, field.most, count);
      policy.*field.value = static_cast<std::uint32_t>(count);
    }
  }
}

void read_world(const JsonValue& value, Problems& problems, WorldSettings& world) {
  const ObjectReader reader(value, "world", problems,
                            {"contact", "policy", "weights", "parameters", "executor", "threads", "sleeping",
                             "substeps", "max_partners", "max_pairs", "max_front_entries"});
  if (const auto* named =
          named_in(reader, "contact", std::span<const simulation::NamedContactModel>(simulation::kContactModels)))
    world.contact = named->model;
  if (const auto* named = named_in(reader, "policy", std::span<const NamedPolicy>(kRecordedPolicies)))
    world.policy.kind = named->kind;
  if (const auto* named = named_in(reader, "executor", std::span<const ExecutorName>(kExecutors)))
    world.executor = named->kind;
  read_policy(reader, world.policy);
  reader.require("sleeping");
  reader.flag("sleeping", world.sleeping);
  std::uint64_t threads = 1, substeps = 1, partners = 1, pairs = world.max_pairs, entries = 64;
  reader.require_whole("threads", 1, 256, threads);
  reader.require_whole("substeps", 1, 16, substeps);
  reader.require_whole("max_partners", 1, 65536, partners);
  // Records from before it was there have none, and none of theirs was full.
  reader.whole("max_pairs", 1024, 1U << 28U, pairs);
  reader.require_whole("max_front_entries", 64, 1U << 26U, entries);
  world.threads = static_cast<int>(threads);
  world.substeps = static_cast<int>(substeps);
  world.max_partners = static_cast<std::uint32_t>(partners);
  world.max_pairs = static_cast<std::uint32_t>(pairs);
  world.max_front_entries = static_cast<std::uint32_t>(entries);
}

void read_made_by(const ObjectReader& top, RecordHeader& header) {
  const JsonValue* value = top.require("made_by");
  if (value == nullptr) return;
  const ObjectReader reader(*value, "made_by", top.problems(),
                            {"version", "commit", "compiler", "flags", "system", "processor", "cores"});
  reader.require_text("version", header.build.version);
  reader.require_text("commit", header.build.commit);
  reader.require_text("compiler", header.build.compiler);
  reader.require_text("flags", header.build.flags);
  reader.require_text("system", header.machine.system);
  reader.require_text("processor", header.machine.processor);
  std::uint64_t cores = 0;
  reader.require_whole("cores", 0, 1U << 20U, cores);
  header.machine.cores = static_cast<int>(cores);
}

void read_scene_part(const ObjectReader& top, RecordHeader& header) {
  const JsonValue* value = top.require("scene");
  if (value == nullptr) return;
  const ObjectReader reader(*value, "scene", top.problems(),
                            {"name", "file", "folder", "bodies", "seed", "start_hash", "shapes", "gaze", "gaze_loop"});
  reader.require_text("name", header.scene_name);
  reader.require_text("file", header.scene_source);
  reader.require_text("folder", header.scene_folder);
  read_optional(reader, "bodies", header.bodies);
  read_optional(reader, "seed", header.seed);
  read_hex(reader, "start_hash", header.start_hash);
  const JsonValue* gaze = reader.require("gaze");
  if (gaze != nullptr && gaze->kind() != JsonValue::Kind::Null) reader.text("gaze", header.gaze.emplace());
  reader.require("gaze_loop");
  reader.flag("gaze_loop", header.gaze_loop);
  const JsonValue* shapes = reader.require("shapes");
  if (shapes == nullptr) return;
  for (std::size_t i = 0; i < shapes->items().size(); ++i) {
    header.shapes.emplace_back();
    read_shape(shapes->items()[i], item_path("scene.shapes", i), top.problems(), header.shapes.back());
  }
}

void read_step_part(const ObjectReader& top, RecordHeader& header) {
  const JsonValue* value = top.require("step");
  if (value == nullptr) return;
  const ObjectReader reader(
      *value, "step", top.problems(),
      {"dt_s", "max_level", "polygons", "backtracking", "frames", "clock", "paced", "deadline_ms", "budget_work"});
  reader.require("dt_s");
  reader.number("dt_s", Range{0, kMaxTimeStepS, true}, header.dt_s);
  std::uint64_t level = 0;
  reader.require_whole("max_level", 0, kMaxTreeDepth, level);
  header.max_level = static_cast<Level>(level);
  for (const auto& [key, flag] : {std::pair("polygons", &header.polygons),
                                  std::pair("backtracking", &header.backtracking), std::pair("paced", &header.paced)}) {
    reader.require(key);
    reader.flag(key, *flag);
  }
  reader.require_whole("frames", 0, kMostFrames, header.frames);
  reader.require_text("clock", header.clock);
  reader.require("deadline_ms");
  reader.number("deadline_ms", kNotNegative, header.deadline_ms);
  read_optional(reader, "budget_work", header.budget_work);
}

}  // namespace

std::string header_json(const RecordHeader& header) {
  const Json json = {{"scene",
                      {{"name", header.scene_name},
                       {"file", header.scene_source},
                       {"folder", header.scene_folder},
                       {"bodies", optional_number(header.bodies)},
                       {"seed", optional_number(header.seed)},
                       {"start_hash", hex(header.start_hash)},
                       {"shapes", shapes_json(header.shapes)},
                       {"gaze", header.gaze ? Json(*header.gaze) : Json(nullptr)},
                       {"gaze_loop", header.gaze_loop}}},
                     {"world", world_json(header.world)},
                     {"step",
                      {{"dt_s", header.dt_s},
                       {"max_level", header.max_level},
                       {"polygons", header.polygons},
                       {"backtracking", header.backtracking},
                       {"frames", header.frames},
                       {"clock", header.clock},
                       {"paced", header.paced},
                       {"deadline_ms", header.deadline_ms},
                       {"budget_work", optional_number(header.budget_work)}}},
                     {"made_by",
                      {{"version", header.build.version},
                       {"commit", header.build.commit},
                       {"compiler", header.build.compiler},
                       {"flags", header.build.flags},
                       {"system", header.machine.system},
                       {"processor", header.machine.processor},
                       {"cores", header.machine.cores}}}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<RecordHeader> read_header(std::string_view json, const std::string& name) {
  const Result<JsonValue> root = parse_json(json, name);
  if (!root) return root.error();
  RecordHeader header;
  Problems problems(name);
  const ObjectReader top(root.value(), "", problems, {"scene", "world", "step", "made_by"});
  read_scene_part(top, header);
  if (const JsonValue* world = top.require("world")) read_world(*world, problems, header.world);
  read_step_part(top, header);
  read_made_by(top, header);
  if (problems.first()) return *problems.first();
  return header;
}

}  // namespace poise::io
