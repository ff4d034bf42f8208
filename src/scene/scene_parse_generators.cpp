// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scene/scene_parse.h"

namespace poise::io {
namespace {

constexpr Range kSpacing{0, kMaxQuantity, true};
constexpr Range kSeconds{0, 1e9, false};
constexpr Range kLife{0, 1e9, true};

void parse_kind(const ObjectReader& reader, const SceneNames& names, const Scene& scene, GeneratedKind& kind) {
  Problems& problems = reader.problems();
  const JsonValue* one = reader.find("shape");
  const JsonValue* several = reader.find("shapes");
  if ((one == nullptr) == (several == nullptr)) {
    problems.refuse(reader.path(), "must have either shape or shapes");
    return;
  }
  const SoundSoFar sound(problems);
  if (one != nullptr) {
    kind.shapes.resize(1);
    read_shape_name(*one, reader.path("shape"), problems, names, kind.shapes[0]);
  } else if (several->kind() != JsonValue::Kind::Array || several->items().empty()) {
    problems.refuse(reader.path("shapes"), *several, "must be a list of at least one name");
  } else {
    kind.shapes.resize(several->items().size());
    for (std::size_t i = 0; i < several->items().size(); ++i) {
      read_shape_name(several->items()[i], item_path(reader.path("shapes"), i), problems, names, kind.shapes[i]);
    }
  }
  for (const std::size_t shape : kind.shapes) {
    if (sound && is_plane(scene, shape)) {
      problems.refuse(reader.path(),
                      fmt::format("shape {} is a plane, must be a solid", in_quotes(scene.shapes[shape].name)));
    }
  }
  std::size_t mix = 0;
  reader.one_of("mix", {"cycle", "seed"}, mix);
  kind.mix_by_seed = mix == 1;
  read_material_name(reader, names, kind.material);
  reader.flag("random_orientation", kind.random_orientation);
  reader.vec3("velocity_mps", kAnyQuantity, kind.velocity_mps);
  reader.number("speed_mps", kNotNegative, kind.speed_mps);
  reader.number("spin_radps", kNotNegative, kind.spin_radps);
  reader.whole("seed", 0, std::numeric_limits<std::uint64_t>::max(), kind.seed);
  reader.bits("group", kind.group);
  reader.bits("collides_with", kind.collides_with);
  reader.number("importance", kImportance, kind.importance);
}

/// Refuses members that belong to another mode of a generator.
void refuse_members(const ObjectReader& reader, std::initializer_list<std::string_view> keys, const char* why) {
  for (const std::string_view key : keys) {
    if (reader.has(key)) reader.problems().refuse(reader.path(key), why);
  }
}

void parse_count(const ObjectReader& reader, GridGenerator& grid) {
  const JsonValue* count = reader.require("count");
  if (count == nullptr) return;
  const std::string path = reader.path("count");
  if (count->kind() != JsonValue::Kind::Array || count->items().size() != 3) {
    reader.problems().refuse(path, *count, "must be a list of 3 whole numbers");
    return;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    read_whole(count->items()[i], item_path(path, i), 1, kMaxSceneBodies, reader.problems(), grid.count[i]);
  }
}

void parse_blocks(const ObjectReader& grid_reader, GridGenerator& grid) {
  const JsonValue* value = grid_reader.find("blocks");
  if (value == nullptr) return;
  const ObjectReader reader(*value, grid_reader.path("blocks"), grid_reader.problems(), {"count", "spacing_m"});
  GridBlocks blocks;
  const JsonValue* count = reader.require("count");
  if (count != nullptr && (count->kind() != JsonValue::Kind::Array || count->items().size() != 2)) {
    reader.problems().refuse(reader.path("count"), *count, "must be a list of 2 whole numbers");
  } else if (count != nullptr) {
    for (std::size_t i = 0; i < 2; ++i) {
      read_whole(count->items()[i], item_path(reader.path("count"), i), 1, kMaxSceneBodies, reader.problems(),
                 blocks.count[i]);
    }
  }
  reader.require("spacing_m");
  reader.pair("spacing_m", kSpacing, blocks.spacing_m);
  grid.blocks = blocks;
}

void parse_static(const ObjectReader& reader, GridGenerator& grid) {
  reader.flag("static", grid.is_static);
  if (!grid.is_static) return;
  const std::pair<const char*, bool> moves[] = {{"velocity_mps", !grid.kind.velocity_mps.isZero(0)},
                                                {"speed_mps", grid.kind.speed_mps > 0},
                                                {"spin_radps", grid.kind.spin_radps > 0}};
  for (const auto& [key, given] : moves) {
    if (given) reader.problems().refuse(reader.path(key), *reader.find(key), "must be zero for a static body");
  }
}

SceneGenerator parse_grid(const JsonValue& value, const std::string& path, Problems& problems, const SceneNames& names,
                          const Scene& scene) {
  const ObjectReader reader(
      value, path, problems,
      {"shape",        "shapes",    "mix",        "material", "static", "count",         "spacing_m",
       "origin_m",     "blocks",    "jitter_m",   "in_tray",  "bodies", "bottom_m",      "random_orientation",
       "velocity_mps", "speed_mps", "spin_radps", "seed",     "group",  "collides_with", "importance"});
  GridGenerator grid;
  if (value.kind() != JsonValue::Kind::Object) return grid;
  parse_kind(reader, names, scene, grid.kind);
  parse_static(reader, grid);
  reader.require("spacing_m");
  reader.number("spacing_m", kSpacing, grid.spacing_m);
  reader.number("jitter_m", kNotNegative, grid.jitter_m);
  reader.flag("in_tray", grid.in_tray);
  if (!grid.in_tray) {
    refuse_members(reader, {"bodies", "bottom_m"}, "only with in_tray; a free grid has count and origin_m");
    parse_count(reader, grid);
    reader.vec3("origin_m", kAnyQuantity, grid.origin_m);
    parse_blocks(reader, grid);
    return grid;
  }
  refuse_members(reader, {"count", "origin_m", "blocks"}, "not with in_tray, which has bodies and bottom_m");
  if (!scene.tray) problems.refuse(reader.path("in_tray"), *reader.find("in_tray"), "needs a tray");
  reader.require("bodies");
  reader.whole("bodies", 1, kMaxSceneBodies, grid.bodies);
  reader.number("bottom_m", kNotNegative, grid.bottom_m);
  return grid;
}

void parse_rate(const ObjectReader& reader, StreamGenerator& stream) {
  Problems& problems = reader.problems();
  const SoundSoFar sound(problems);
  double per_second = 0;
  reader.require("per_second");
  reader.number("per_second", kPositive, per_second);
  reader.number("from_s", kSeconds, stream.from_s);
  if (reader.has("to_s") == reader.has("total")) {
    problems.refuse(reader.path(), "must have either to_s or total");
    return;
  }
  reader.whole("total", 1, kMaxSceneBodies, stream.total);
  reader.number("to_s", kSeconds, stream.to_s);
  if (!sound) return;
  if (reader.has("total")) {
    stream.to_s = stream.from_s + static_cast<double>(stream.total) / per_second;
    return;
  }
  const double bodies = std::round(per_second * (stream.to_s - stream.from_s));
  if (!(stream.to_s > stream.from_s)) {
    problems.refuse(reader.path("to_s"), *reader.find("to_s"), "must be > from_s");
  } else if (!(bodies >= 1) || !(bodies <= static_cast<double>(kMaxSceneBodies))) {
    problems.refuse(reader.path(), fmt::format("makes {:g} bodies, must make 1 to {}", bodies, kMaxSceneBodies));
  } else {
    stream.total = static_cast<std::uint64_t>(bodies);
  }
}

SceneGenerator parse_stream(const JsonValue& value, const std::string& path, Problems& problems,
                            const SceneNames& names, const Scene& scene) {
  const ObjectReader reader(value, path, problems,
                            {"shape", "shapes", "mix", "material", "per_second", "from_s", "to_s", "total",
                             "region_min_m", "region_max_m", "life_s", "random_orientation", "velocity_mps",
                             "speed_mps", "spin_radps", "seed", "group", "collides_with", "importance"});
  StreamGenerator stream;
  if (value.kind() != JsonValue::Kind::Object) return stream;
  parse_kind(reader, names, scene, stream.kind);
  parse_rate(reader, stream);
  if (reader.has("life_s")) {
    double life_s = 1;
    reader.number("life_s", kLife, life_s);
    stream.life_s = life_s;
  }
  const SoundSoFar sound(problems);
  reader.require("region_min_m");
  const JsonValue* max = reader.require("region_max_m");
  reader.vec3("region_min_m", kAnyQuantity, stream.region_min_m);
  reader.vec3("region_max_m", kAnyQuantity, stream.region_max_m);
  if (sound && (stream.region_max_m - stream.region_min_m).minCoeff() < 0) {
    problems.refuse(reader.path("region_max_m"), *max, "must not be below region_min_m");
  }
  return stream;
}

}  // namespace

void parse_tray(const JsonValue& value, Problems& problems, const SceneNames& names, Scene& scene) {
  const ObjectReader reader(value, "tray", problems, {"material", "side_m", "side_per_sqrt_body_m"});
  SceneTray tray;
  scene.tray = tray;
  if (value.kind() != JsonValue::Kind::Object) return;
  read_material_name(reader, names, tray.material);
  if (reader.has("side_m") == reader.has("side_per_sqrt_body_m")) {
    problems.refuse("tray", "must have either side_m or side_per_sqrt_body_m");
  }
  reader.number("side_m", kPositive, tray.side_m);
  reader.number("side_per_sqrt_body_m", kPositive, tray.side_per_sqrt_body_m);
  scene.tray = tray;
}

void parse_generators(const JsonValue& value, Problems& problems, const SceneNames& names, Scene& scene) {
  if (value.kind() != JsonValue::Kind::Array) {
    problems.refuse("generators", value, "must be a list");
    return;
  }
  for (std::size_t i = 0; i < value.items().size(); ++i) {
    const std::string path = item_path("generators", i);
    const ObjectReader reader(value.items()[i], path, problems, {"grid", "stream"});
    if (value.items()[i].kind() == JsonValue::Kind::Object && value.items()[i].items().size() != 1) {
      problems.refuse(path, "must have exactly one of grid, stream");
    }
    if (const JsonValue* grid = reader.find("grid")) {
      scene.generators.push_back(parse_grid(*grid, reader.path("grid"), problems, names, scene));
    } else if (const JsonValue* stream = reader.find("stream")) {
      scene.generators.push_back(parse_stream(*stream, reader.path("stream"), problems, names, scene));
    }
  }
  if (scene.tray && scene.generators.empty() && scene.tray->side_per_sqrt_body_m > 0) {
    problems.refuse("tray.side_per_sqrt_body_m", "needs a generator");
  }
}

}  // namespace poise::io
