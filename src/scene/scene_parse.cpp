// SPDX-License-Identifier: MIT
#include "scene/scene_parse.h"

#include <fmt/format.h>

#include <cmath>
#include <system_error>
#include <utility>

#include "assets/files/text_file.h"
#include "scene/islands_wait_name.h"

namespace poise {
namespace io {
namespace {

constexpr std::uintmax_t kMaxSceneBytes = 256U << 20U;
constexpr Range kDeadline{0, 1e6, true};
constexpr Range kHostWork{0, 1e6, false};
constexpr Range kAlpha{1e-5, 0.5, false};

bool is_blank(std::string_view text) { return text.find_first_not_of(" \t\r\n") == std::string_view::npos; }

/// Index of the name in `value`. The list of all names is built only if a suggestion is needed.
template <class Named>
void read_name(const JsonValue& value, const std::string& path, Problems& problems, const char* what,
               const NameIndex<Named>& index, std::size_t& target) {
  if (value.kind() != JsonValue::Kind::String) {
    problems.refuse(path, value, fmt::format("must be the name of a {}", what));
    return;
  }
  // An empty list of names was refused already.
  if (index.list().empty()) return;
  if (const auto found = index.find(value.text())) {
    target = *found;
    return;
  }
  std::vector<std::string_view> names;
  if (problems.suggests()) {
    for (const Named& named : index.list()) names.emplace_back(named.name);
  }
  problems.refuse(path, value, fmt::format("must be the name of a {}{}", what, problems.suggest(value.text(), names)));
}

void parse_frame(const ObjectReader& top, Scene& scene) {
  const JsonValue* name = top.require("name");
  top.text("name", scene.name);
  if (name != nullptr && name->kind() == JsonValue::Kind::String && name->text().empty()) {
    top.problems().refuse("name", *name, "must not be empty");
  }
  top.text("description", scene.description);
  top.require("dt_s");
  top.number("dt_s", kTimeStep, scene.dt_s);
  top.vec3("gravity_mps2", kAnyQuantity, scene.gravity_mps2);
  top.whole("frames", 1, kMaxSceneFrames, scene.frames);
  top.whole("seed", 0, UINT64_MAX, scene.seed);
  if (top.has("deadline_ms")) {
    double deadline_ms = 1;
    top.number("deadline_ms", kDeadline, deadline_ms);
    scene.deadline_ms = deadline_ms;
  }
  if (top.has("alpha")) {
    double alpha = 0.01;
    top.number("alpha", kAlpha, alpha);
    scene.alpha = alpha;
  }
}

void parse_host_work(const JsonValue& value, Problems& problems, Scene& scene) {
  const ObjectReader reader(value, "host_work", problems, {"load_ms", "jitter_ms", "reserve_ms"});
  const SoundSoFar sound(problems);
  SceneHostWork work;
  reader.number("load_ms", kHostWork, work.load_ms);
  reader.number("jitter_ms", kHostWork, work.jitter_ms);
  if (sound && work.jitter_ms > work.load_ms)
    problems.refuse("host_work.jitter_ms", *reader.find("jitter_ms"), "must be at most load_ms");
  if (reader.has("reserve_ms")) {
    double reserve_ms = 0;
    reader.number("reserve_ms", kHostWork, reserve_ms);
    work.reserve_ms = reserve_ms;
  }
  scene.host_work = work;
}

void parse_max_level(const ObjectReader& top, Scene& scene) {
  const JsonValue* value = top.find("max_level");
  if (value == nullptr) return;
  if (value->kind() == JsonValue::Kind::String) {
    scene.polygons = value->text() == "polygons";
    if (!scene.polygons) {
      top.problems().refuse("max_level", *value,
                            fmt::format("must be a whole number from 0 to {}, or \"polygons\"{}", kMaxTreeDepth,
                                        top.problems().suggest(value->text(), {"polygons"})));
    }
    return;
  }
  std::uint64_t level = kMaxTreeDepth;
  read_whole(*value, "max_level", 0, kMaxTreeDepth, top.problems(), level);
  scene.max_level = static_cast<Level>(level);
}

void parse_gaze_px(const ObjectReader& top, Scene& scene) {
  const JsonValue* value = top.find("gaze_px");
  if (value == nullptr) return;
  const SoundSoFar sound(top.problems());
  std::array<double, 2> gaze{};
  top.pair("gaze_px", kNotNegative, gaze);
  scene.gaze_px = gaze;
  if (!scene.camera) {
    top.problems().refuse("gaze_px", *value, "needs a camera");
    return;
  }
  if (!sound) return;
  const std::array<double, 2>& size = scene.camera->resolution_px;
  if (gaze[0] > size[0] || gaze[1] > size[1]) {
    top.problems().refuse("gaze_px", *value,
                          fmt::format("must lie in the image of {:g} x {:g} pixels", size[0], size[1]));
  }
}

void parse_top(const JsonValue& root, Problems& problems, Scene& scene) {
  const ObjectReader top(
      root, "", problems,
      {"name",      "description", "gravity_mps2", "dt_s",     "frames",       "seed",      "deadline_ms", "alpha",
       "host_work", "max_level",   "backtracking", "sleeping", "islands_wait", "policy",    "camera",      "gaze_px",
       "gaze",      "materials",   "shapes",       "bodies",   "tray",         "generators"});
  if (root.kind() != JsonValue::Kind::Object) return;
  parse_frame(top, scene);
  parse_max_level(top, scene);
  top.flag("backtracking", scene.backtracking);
  top.flag("sleeping", scene.sleeping);
  auto wait = static_cast<std::size_t>(scene.islands_wait);
  top.one_of("islands_wait", {kIslandsWaitNames.begin(), kIslandsWaitNames.end()}, wait);
  scene.islands_wait = static_cast<IslandsWait>(wait);
  if (const JsonValue* value = top.find("host_work")) parse_host_work(*value, problems, scene);
  if (const JsonValue* value = top.find("policy")) parse_policy(*value, problems, scene.policy);
  if (const JsonValue* value = top.find("camera")) parse_camera(*value, problems, scene);
  parse_gaze_px(top, scene);
  if (const JsonValue* value = top.find("gaze")) parse_scene_gaze(*value, problems, scene);
  if (const JsonValue* value = top.require("materials")) parse_materials(*value, problems, scene);
  if (const JsonValue* value = top.require("shapes")) parse_shapes(*value, problems, scene);
  const SoundSoFar sound(problems);
  const SceneNames names(scene);
  if (const JsonValue* value = top.find("bodies")) parse_bodies(*value, problems, names, scene);
  if (const JsonValue* value = top.find("tray")) parse_tray(*value, problems, names, scene);
  if (const JsonValue* value = top.find("generators")) parse_generators(*value, problems, names, scene);
  if (sound && scene.bodies.empty() && scene.generators.empty()) {
    problems.refuse("", "bodies and generators are both empty or missing, at least one body or generator is required");
  }
  const std::uint64_t generated = generated_body_count(scene);
  if (generated + scene.bodies.size() > kMaxSceneBodies) {
    problems.refuse("generators",
                    fmt::format("make {} bodies, the scene must have at most {}", generated, kMaxSceneBodies));
  }
}

}  // namespace

bool is_plane(const Scene& scene, std::size_t shape) {
  return shape < scene.shapes.size() && std::holds_alternative<PlaneSource>(scene.shapes[shape].source);
}

void read_shape_name(const JsonValue& value, const std::string& path, Problems& problems, const SceneNames& names,
                     std::size_t& target) {
  read_name(value, path, problems, "shape", names.shapes, target);
}

void read_material_name(const ObjectReader& reader, const SceneNames& names, std::size_t& target) {
  const JsonValue* value = reader.require("material");
  if (value == nullptr) return;
  read_name(*value, reader.path("material"), reader.problems(), "material", names.materials, target);
}

}  // namespace io

Result<Scene> parse_scene(std::string_view text, const std::string& name, const std::filesystem::path& base,
                          std::vector<std::string>* errors) {
  if (errors != nullptr) errors->clear();
  Result<io::JsonValue> root = io::parse_json(text, name);
  if (!root) {
    if (errors != nullptr) errors->push_back(root.error().message);
    return root.error();
  }
  Scene scene;
  scene.source = name;
  scene.base = base;
  io::Problems problems(name);
  io::parse_top(root.value(), problems, scene);
  if (problems.count() == 0) return scene;
  if (errors != nullptr) {
    *errors = problems.all();
    if (problems.count() > errors->size())
      errors->push_back(fmt::format("{}: and {} more", name, problems.count() - errors->size()));
  }
  return *problems.first();
}

Result<std::string> io::read_scene_text(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(file, failure);
  if (!std::filesystem::exists(status)) return bad_input(name + ": no such file");
  if (std::filesystem::is_directory(status)) return bad_input(name + ": is a directory, must be a scene file");
  // Opening a pipe blocks until a writer opens it, and some devices never end.
  if (!std::filesystem::is_regular_file(status))
    return bad_input(name + ": is a pipe or a device, must be a file; SCENE - reads the standard input");
  Result<std::string> text = geometry::read_bytes(file, kMaxSceneBytes);
  if (!text) return bad_input(fmt::format("{}: {}; must be a scene file", name, text.error().message));
  if (is_blank(text.value())) return bad_input(name + ": the file is empty");
  return text;
}

Result<std::string> io::read_scene_stream(std::istream& stream, const std::string& name) {
  std::string text;
  std::vector<char> block(1U << 16U);
  while (stream.good()) {
    stream.read(block.data(), static_cast<std::streamsize>(block.size()));
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.size() > io::kMaxSceneBytes) return bad_input(name + ": larger than 256 MiB, must be a scene file");
  }
  if (stream.bad()) return bad_input(name + ": cannot be read");
  if (is_blank(text)) return bad_input(name + ": the file is empty");
  return text;
}

Result<Scene> read_scene(const std::filesystem::path& file) {
  const Result<std::string> text = io::read_scene_text(file);
  if (!text) return text.error();
  return parse_scene(text.value(), file.string(), file.parent_path());
}

}  // namespace poise
