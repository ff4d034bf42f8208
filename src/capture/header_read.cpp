// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/bytes.h"
#include "capture/header.h"
#include "scene/field_reader.h"

namespace poise::capture {
namespace {

using io::item_path;
using io::JsonValue;
using io::ObjectReader;
using io::Problems;
using io::Range;

constexpr std::uint64_t kMostRows = std::numeric_limits<std::uint32_t>::max();
constexpr Range kAny{-std::numeric_limits<double>::max(), std::numeric_limits<double>::max(), false};
constexpr Range kNotNegative{0, std::numeric_limits<double>::max(), false};
constexpr Range kPositive{0, std::numeric_limits<double>::max(), true};

void require_vec3(const ObjectReader& reader, std::string_view key, std::array<double, 3>& target) {
  Vec3 read = Vec3::Zero();
  reader.require(key);
  reader.vec3(key, kAny, read);
  target = {read.x(), read.y(), read.z()};
}

/// The items of a member that is an array; none where it is not, which is refused.
JsonValue::Items items_of(const ObjectReader& reader, std::string_view key) {
  const JsonValue::Items none(nullptr, 0);
  const JsonValue* value = reader.require(key);
  if (value == nullptr) return none;
  if (value->kind() == JsonValue::Kind::Array) return value->items();
  reader.problems().refuse(reader.path(key), *value, "must be an array");
  return none;
}

bool is_null(const ObjectReader& reader, std::string_view key) {
  const JsonValue* value = reader.require(key);
  return value == nullptr || value->kind() == JsonValue::Kind::Null;
}

void read_made_by(const ObjectReader& top, CaptureHeader& header) {
  if (const JsonValue* value = top.require("build")) {
    const ObjectReader build(*value, "build", top.problems(), {"version", "commit", "compiler", "flags"});
    build.require_text("version", header.build.version);
    build.require_text("commit", header.build.commit);
    build.require_text("compiler", header.build.compiler);
    build.require_text("flags", header.build.flags);
  }
  if (const JsonValue* value = top.require("machine")) {
    const ObjectReader machine(*value, "machine", top.problems(), {"system", "processor", "cores"});
    machine.require_text("system", header.machine.system);
    machine.require_text("processor", header.machine.processor);
    std::uint64_t cores = 0;
    machine.require_whole("cores", 0, 1U << 20U, cores);
    header.machine.cores = static_cast<int>(cores);
  }
}

void read_shapes(const ObjectReader& top, CaptureHeader& header) {
  const JsonValue::Items items = items_of(top, "shapes");
  for (std::size_t i = 0; i < items.size(); ++i) {
    const ObjectReader reader(items[i], item_path("shapes", i), top.problems(),
                              {"name", "kind", "radius_m", "triangles", "levels", "normal", "offset_m"});
    CapturedShape& shape = header.shapes.emplace_back();
    std::size_t kind = 0;
    std::uint64_t triangles = 0, levels = 0;
    reader.require_text("name", shape.name);
    reader.require("kind");
    reader.one_of("kind", {"tree", "plane"}, kind);
    shape.plane = kind == 1;
    reader.require_number("radius_m", kNotNegative, shape.radius_m);
    reader.require_whole("triangles", 0, kMostRows, triangles);
    reader.require_whole("levels", 0, kMaxTreeDepth + 1, levels);
    if (!shape.plane) continue;
    require_vec3(reader, "normal", shape.normal);
    reader.require_number("offset_m", kAny, shape.offset_m);
  }
}

void read_materials(const ObjectReader& top, CaptureHeader& header) {
  const JsonValue::Items items = items_of(top, "materials");
  for (std::size_t i = 0; i < items.size(); ++i) {
    const ObjectReader reader(items[i], item_path("materials", i), top.problems(),
                              {"name", "friction", "restitution", "density_kgpm3"});
    CapturedMaterial& material = header.materials.emplace_back();
    reader.require_text("name", material.name);
    reader.require_number("friction", kNotNegative, material.friction);
    reader.require_number("restitution", kNotNegative, material.restitution);
    reader.require_number("density_kgpm3", kNotNegative, material.density_kgpm3);
  }
}

void read_run(const ObjectReader& top, CaptureHeader& header) {
  top.require_text("scene", header.scene);
  const JsonValue::Items words = items_of(top, "command");
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i].kind() != JsonValue::Kind::String)
      top.problems().refuse(item_path("command", i), words[i], "must be a text");
    header.command.emplace_back(words[i].text());
  }
  top.require_number("dt_s", Range{0, kMaxTimeStepS, true}, header.dt_s);
  if (!is_null(top, "deadline_ms")) top.number("deadline_ms", kNotNegative, header.deadline_ms.emplace());
  top.require_flag("paced", header.paced);
  if (!is_null(top, "frames_asked")) top.whole("frames_asked", 0, kVarintEnd, header.frames_asked.emplace());
  require_vec3(top, "gravity_mps2", header.gravity_mps2);
  std::uint64_t threads = 1, steps = 1;
  top.require_whole("threads", 1, 1U << 16U, threads);
  header.threads = static_cast<int>(threads);
  top.require_text("policy", header.policy);
  top.require_text("contact", header.contact);
  top.require_number("position_step_m", kPositive, header.position_step_m);
  top.require_whole("orientation_steps", kLeastOrientationSteps, kMostOrientationSteps, steps);
  header.orientation_steps = static_cast<std::uint32_t>(steps);
  double error_rad = 0;
  top.require_number("orientation_error_rad", kPositive, error_rad);
  top.require_flag("contacts", header.contacts);
  if (is_null(top, "camera")) return;
  const ObjectReader camera(*top.find("camera"), "camera", top.problems(), {"resolution_px", "moves"});
  header.camera.emplace();
  camera.require("resolution_px");
  camera.pair("resolution_px", kPositive, header.camera->resolution_px);
  camera.require_flag("moves", header.camera->moves);
}

/// A column of BODY: as many whole numbers up to `most` as there are rows.
std::vector<std::uint64_t> column(const ObjectReader& reader, const char* key, std::uint64_t most, std::size_t rows) {
  const JsonValue::Items items = items_of(reader, key);
  if (items.size() != rows)
    reader.problems().refuse(reader.path(key), fmt::format("has {} items, must have {}", items.size(), rows));
  std::vector<std::uint64_t> values(rows, 0);
  for (std::size_t i = 0; i < std::min(rows, items.size()); ++i)
    io::read_whole(items[i], item_path(key, i), 0, most, reader.problems(), values[i]);
  return values;
}

}  // namespace

Result<CaptureHeader> read_header(std::string_view json) {
  const Result<JsonValue> root = io::parse_json(json, "HEAD");
  if (!root) return root.error();
  Problems problems("HEAD");
  const ObjectReader top(root.value(), "", problems,
                         {"schema",
                          "scene",
                          "command",
                          "build",
                          "machine",
                          "dt_s",
                          "deadline_ms",
                          "paced",
                          "frames_asked",
                          "gravity_mps2",
                          "threads",
                          "policy",
                          "contact",
                          "position_step_m",
                          "orientation_steps",
                          "orientation_error_rad",
                          "contacts",
                          "camera",
                          "materials",
                          "shapes"});
  CaptureHeader header;
  std::size_t schema = 0;
  top.require("schema");
  top.one_of("schema", {kSchema}, schema);
  read_run(top, header);
  read_made_by(top, header);
  read_materials(top, header);
  read_shapes(top, header);
  if (problems.first()) return *problems.first();
  return header;
}

Status read_shape(std::string_view bytes, std::uint32_t index, CapturedShape& shape) {
  ByteReader reader(bytes);
  const std::string name = fmt::format("SHAP {}", index);
  const auto is = reader.get<std::uint32_t>();
  const auto vertices = reader.get<std::uint32_t>();
  const auto triangles = reader.get<std::uint32_t>();
  const auto fits = [&](std::uint64_t count, std::uint64_t each) {
    return reader.sound() && count * each <= reader.left();
  };
  if (!fits(vertices, 12) || !fits(triangles, 12)) return bad_input(name + ": it ends within the triangles");
  if (is != index) return bad_input(fmt::format("{}: shape = {}, must be {}", name, is, index));
  shape.vertices_m.resize(std::size_t{3} * vertices);
  for (float& coordinate : shape.vertices_m) {
    coordinate = reader.get<float>();
    if (!std::isfinite(coordinate)) return bad_input(name + ": a vertex is not finite");
  }
  if (!fits(triangles, 12)) return bad_input(name + ": it ends within the triangles");
  shape.corners.resize(std::size_t{3} * triangles);
  for (std::uint32_t& corner : shape.corners) {
    corner = reader.get<std::uint32_t>();
    if (corner >= vertices)
      return bad_input(fmt::format("{}: a corner = {}, must be below {}", name, corner, vertices));
  }
  const auto levels = reader.get<std::uint32_t>();
  if (!reader.sound() || levels > kMaxTreeDepth + 1U)
    return bad_input(fmt::format("{}: levels = {}, must be at most {}", name, levels, kMaxTreeDepth + 1U));
  shape.levels.resize(levels);
  for (std::vector<CapturedSphere>& level : shape.levels) {
    const auto spheres = reader.get<std::uint32_t>();
    if (!fits(spheres, 16)) return bad_input(name + ": it ends within the spheres");
    level.resize(spheres);
    for (CapturedSphere& sphere : level) {
      for (float* value : {&sphere.x_m, &sphere.y_m, &sphere.z_m, &sphere.radius_m}) *value = reader.get<float>();
      if (!std::isfinite(sphere.x_m + sphere.y_m + sphere.z_m) || !(sphere.radius_m >= 0) ||
          !std::isfinite(sphere.radius_m))
        return bad_input(name + ": a sphere is not finite, or its radius below 0");
    }
  }
  if (!reader.sound() || reader.left() != 0) return bad_input(name + ": its length is not that of its content");
  return Done{};
}

Status read_bodies(std::string_view json, const CaptureHeader& header, std::vector<CapturedBody>& bodies) {
  const Result<JsonValue> root = io::parse_json(json, "BODY");
  if (!root) return root.error();
  Problems problems("BODY");
  const ObjectReader top(root.value(), "", problems,
                         {"first", "number", "shape", "material", "motion", "mass_kg", "name"});
  std::uint64_t first = 0;
  top.require_whole("first", bodies.size(), bodies.size(), first);
  const std::size_t rows = items_of(top, "number").size();
  if (bodies.size() + rows > kMostRows) problems.refuse("number", "there are more rows than 2^32");
  if (header.shapes.empty() && rows > 0) problems.refuse("shape", "there are no shapes");
  const auto last = [](std::size_t size) { return size == 0 ? 0 : size - 1; };
  const std::vector<std::uint64_t> number = column(top, "number", kVarintEnd, rows);
  const std::vector<std::uint64_t> shape = column(top, "shape", last(header.shapes.size()), rows);
  const std::vector<std::uint64_t> material = column(top, "material", last(header.materials.size()), rows);
  const std::vector<std::uint64_t> motion = column(top, "motion", 2, rows);
  const JsonValue::Items mass = items_of(top, "mass_kg");
  if (mass.size() != rows) problems.refuse("mass_kg", fmt::format("has {} items, must have {}", mass.size(), rows));
  const JsonValue* names = top.find("name");
  if (names != nullptr && names->items().size() != rows)
    problems.refuse("name", fmt::format("has {} items, must have {}", names->items().size(), rows));
  if (problems.first()) return *problems.first();
  for (std::size_t i = 0; i < rows; ++i) {
    CapturedBody body;
    body.number = number[i];
    body.shape = static_cast<std::uint32_t>(shape[i]);
    body.material = static_cast<std::uint32_t>(material[i]);
    body.motion = static_cast<MotionType>(motion[i]);
    io::read_number(mass[i], item_path("mass_kg", i), kNotNegative, problems, body.mass_kg);
    if (names != nullptr) body.name = names->items()[i].text();
    if (!bodies.empty() && body.number <= bodies.back().number)
      problems.refuse(item_path("number", i), fmt::format("= {}, must ascend", body.number));
    bodies.push_back(std::move(body));
  }
  return problems.first() ? Status(*problems.first()) : Status(Done{});
}

Result<CaptureIndex> read_index(std::string_view json) {
  const Result<JsonValue> root = io::parse_json(json, "INDX");
  if (!root) return root.error();
  Problems problems("INDX");
  const ObjectReader top(root.value(), "", problems, {"blocks", "bodies", "frames", "left_out", "stopped"});
  CaptureIndex index;
  if (const JsonValue* value = top.require("blocks")) {
    const ObjectReader blocks(*value, "blocks", problems, {"at", "frame", "frames"});
    const std::size_t count = items_of(blocks, "at").size();
    const std::vector<std::uint64_t> at = column(blocks, "at", kVarintEnd, count);
    const std::vector<std::uint64_t> frame = column(blocks, "frame", kVarintEnd, count);
    const std::vector<std::uint64_t> frames = column(blocks, "frames", kMostBlockFrames, count);
    for (std::size_t i = 0; i < count; ++i)
      index.blocks.push_back({at[i], frame[i], static_cast<std::uint32_t>(frames[i])});
  }
  index.bodies = column(top, "bodies", kVarintEnd, items_of(top, "bodies").size());
  top.require_whole("frames", 0, kVarintEnd, index.end.frames);
  top.require_whole("left_out", 0, kVarintEnd, index.end.left_out);
  top.require_flag("stopped", index.end.stopped);
  if (problems.first()) return *problems.first();
  return index;
}

}  // namespace poise::capture
