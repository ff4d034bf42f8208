// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <string_view>
#include <utility>

#include "scene/run/policy_name.h"
#include "scene/scene_parse.h"

namespace poise::io {
namespace {

constexpr Range kLength{1e-9, kMaxQuantity, false};
constexpr Range kMoment{0, 1e18, true};
// What a World takes (world/validation.h), so that a scene is refused before trees are built.
constexpr Range kMass{1e-18, 1e18, false};
constexpr Range kDensity{1e-9, kMaxQuantity, false};
constexpr Range kFriction{0, 1e6, false};

void parse_sphere(const JsonValue& value, const std::string& path, Problems& problems, SceneShape& shape) {
  const ObjectReader reader(value, path, problems, {"radius_m"});
  SphereSource source;
  reader.require("radius_m");
  reader.number("radius_m", kLength, source.radius_m);
  shape.source = source;
}

void parse_plane(const JsonValue& value, const std::string& path, Problems& problems, SceneShape& shape) {
  const ObjectReader reader(value, path, problems, {"normal", "offset_m"});
  PlaneSource source;
  const SoundSoFar sound(problems);
  const JsonValue* normal = reader.require("normal");
  reader.vec3("normal", kAnyQuantity, source.normal);
  if (sound && !(source.normal.norm() > 1e-100)) problems.refuse(reader.path("normal"), *normal, "must not be zero");
  reader.number("offset_m", kAnyQuantity, source.offset_m);
  shape.source = source;
}

void read_file_name(const ObjectReader& reader, const char* key, std::filesystem::path& target) {
  const JsonValue* file = reader.find(key);
  std::string text;
  reader.text(key, text);
  if (file != nullptr && file->kind() == JsonValue::Kind::String &&
      (text.empty() || text.find('\0') != std::string::npos)) {
    reader.problems().refuse(reader.path(key), *file, "must be the name of a file");
  }
  target = text;
}

void read_file(const ObjectReader& reader, std::filesystem::path& target) {
  reader.require("file");
  read_file_name(reader, "file", target);
}

/// Reads four numbers w x y z, not all 0, and normalises them. On refusal the target is unchanged.
void read_rotation(const ObjectReader& reader, std::string_view key, Quat& target) {
  const JsonValue* value = reader.find(key);
  if (value == nullptr) return;
  const std::string path = reader.path(key);
  if (value->kind() != JsonValue::Kind::Array || value->items().size() != 4) {
    reader.problems().refuse(path, *value, "must be a list of 4 numbers, w x y z");
    return;
  }
  const SoundSoFar sound(reader.problems());
  std::array<double, 4> wxyz{};
  for (std::size_t i = 0; i < 4; ++i) {
    read_number(value->items()[i], item_path(path, i), kAnyQuantity, reader.problems(), wxyz[i]);
  }
  if (!sound) return;
  const Quat given(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!(given.norm() > 1e-100)) {
    reader.problems().refuse(path, *value, "must not be zero");
    return;
  }
  target = given.normalized();
}

/// Reads the rotation of a mesh, which is applied before anything else.
void parse_turn(const ObjectReader& reader, MeshSource& source) {
  source.turned = reader.has("up") || reader.has("rotation_wxyz");
  if (reader.has("up") && reader.has("rotation_wxyz")) {
    reader.problems().refuse(reader.path("rotation_wxyz"), "not with up, which is a rotation too");
    return;
  }
  // A quarter turn about x or y, so that the other axes point in the expected directions.
  constexpr double kHalf = std::numbers::sqrt2 / 2;
  const std::array<Quat, 6> turns{Quat(kHalf, 0, -kHalf, 0), Quat(kHalf, 0, kHalf, 0), Quat(kHalf, kHalf, 0, 0),
                                  Quat(kHalf, -kHalf, 0, 0), Quat::Identity(),         Quat(0, 1, 0, 0)};
  std::size_t up = 4;
  reader.one_of("up", {"x", "-x", "y", "-y", "z", "-z"}, up);
  source.rotation = turns[up];
  read_rotation(reader, "rotation_wxyz", source.rotation);
}

void parse_mesh(const JsonValue& value, const std::string& path, Problems& problems, SceneShape& shape) {
  const ObjectReader reader(value, path, problems,
                            {"file", "scale", "depth", "shell_thickness_m", "up", "rotation_wxyz"});
  MeshSource source;
  read_file(reader, source.file);
  reader.number("scale", kPositive, source.scale);
  std::uint64_t depth = source.depth;
  reader.whole("depth", 0, kMaxTreeDepth, depth);
  source.depth = static_cast<Level>(depth);
  reader.number("shell_thickness_m", kLength, source.shell_thickness_m);
  parse_turn(reader, source);
  shape.source = std::move(source);
}

void parse_tree(const JsonValue& value, const std::string& path, Problems& problems, SceneShape& shape) {
  const ObjectReader reader(value, path, problems, {"file", "scale", "mesh", "allow_leaks", "shell_thickness_m"});
  TreeSource source;
  read_file(reader, source.file);
  reader.number("scale", kPositive, source.scale);
  read_file_name(reader, "mesh", source.mesh);
  reader.flag("allow_leaks", source.allow_leaks);
  reader.number("shell_thickness_m", kLength, source.shell_thickness_m);
  for (const char* key : {"allow_leaks", "shell_thickness_m"}) {
    const JsonValue* given = reader.find(key);
    if (given != nullptr && reader.find("mesh") == nullptr)
      problems.refuse(reader.path(key), *given, "needs a mesh beside it");
  }
  shape.source = std::move(source);
}

void parse_spheres(const JsonValue& value, const std::string& path, Problems& problems, SceneShape& shape) {
  const ObjectReader reader(value, path, problems, {"centers_m", "radii_m"});
  SpheresSource source;
  const JsonValue* centers = reader.require("centers_m");
  const JsonValue* radii = reader.require("radii_m");
  if (centers == nullptr || radii == nullptr) return;
  if (centers->kind() != JsonValue::Kind::Array || centers->items().empty()) {
    problems.refuse(reader.path("centers_m"), *centers, "must be a list of at least one point");
    return;
  }
  if (radii->kind() != JsonValue::Kind::Array || radii->items().size() != centers->items().size()) {
    problems.refuse(reader.path("radii_m"), *radii,
                    fmt::format("must be a list of {} numbers, one for each centre", centers->items().size()));
    return;
  }
  source.spheres.resize(centers->items().size());
  for (std::size_t i = 0; i < source.spheres.size(); ++i) {
    read_vec3(centers->items()[i], item_path(reader.path("centers_m"), i), kAnyQuantity, problems,
              source.spheres[i].center_m);
    read_number(radii->items()[i], item_path(reader.path("radii_m"), i), kLength, problems, source.spheres[i].radius_m);
  }
  shape.source = std::move(source);
}

void parse_inertia(const ObjectReader& reader, BodyDefinition& body) {
  const JsonValue* value = reader.find("inertia_kgm2");
  if (value == nullptr) return;
  const SoundSoFar sound(reader.problems());
  reader.vec3("inertia_kgm2", kMoment, body.inertia_kgm2);
  const Vec3& moments = body.inertia_kgm2;
  if (sound && 2 * moments.maxCoeff() > moments.sum()) {
    reader.problems().refuse(reader.path("inertia_kgm2"), *value,
                             "must keep the triangle inequality: no moment larger than the other two together");
  }
}

// "static": true means the same as "motion": "static"; if both are given, they must agree.
void parse_motion(const ObjectReader& reader, BodyDefinition& definition) {
  bool is_static = false;
  reader.flag("static", is_static);
  if (is_static) definition.motion = MotionType::Static;
  const JsonValue* given = reader.find("motion");
  if (given == nullptr) return;
  std::string name;
  reader.text("motion", name);
  constexpr std::pair<std::string_view, MotionType> kNames[] = {
      {"static", MotionType::Static}, {"kinematic", MotionType::Kinematic}, {"dynamic", MotionType::Dynamic}};
  const auto* const known =
      std::find_if(std::begin(kNames), std::end(kNames), [&](const auto& entry) { return entry.first == name; });
  if (known == std::end(kNames)) {
    reader.problems().refuse(reader.path("motion"), *given, R"(must be "static", "kinematic" or "dynamic")");
  } else if (reader.has("static") && is_static != (known->second == MotionType::Static)) {
    reader.problems().refuse(reader.path("motion"), *given, "must agree with static");
  } else {
    definition.motion = known->second;
  }
}

/// `plane`: the shape is known to be a plane.
void check_static(const ObjectReader& reader, bool plane, const SceneBody& body) {
  Problems& problems = reader.problems();
  if (plane && body.definition.motion != MotionType::Static) {
    problems.refuse(reader.path("static"), "must be true, since the shape is a plane");
  }
  if (body.definition.motion != MotionType::Static) return;
  for (const char* key : {"velocity_mps", "angular_velocity_radps"}) {
    const JsonValue* value = reader.find(key);
    const Vec3& speed = key[0] == 'v' ? body.definition.velocity_mps : body.definition.angular_velocity_radps;
    if (value != nullptr && !speed.isZero(0))
      problems.refuse(reader.path(key), *value, "must be zero for a static body");
  }
}

void parse_body(const JsonValue& value, const std::string& path, Problems& problems, const SceneNames& names,
                Scene& scene) {
  const ObjectReader reader(
      value, path, problems,
      {"name", "shape", "material", "static", "motion", "position_m", "orientation_wxyz", "velocity_mps",
       "angular_velocity_radps", "mass_kg", "inertia_kgm2", "group", "collides_with", "importance"});
  if (value.kind() != JsonValue::Kind::Object) return;
  SceneBody body;
  reader.text("name", body.name);
  const SoundSoFar shape_known(problems);
  if (const JsonValue* shape = reader.require("shape"))
    read_shape_name(*shape, reader.path("shape"), problems, names, body.shape);
  const bool plane = shape_known && is_plane(scene, body.shape);
  read_material_name(reader, names, body.material);
  BodyDefinition& definition = body.definition;
  parse_motion(reader, definition);
  reader.vec3("position_m", kAnyQuantity, definition.position_m);
  read_rotation(reader, "orientation_wxyz", definition.orientation);
  reader.vec3("velocity_mps", kAnyQuantity, definition.velocity_mps);
  reader.vec3("angular_velocity_radps", kAnyQuantity, definition.angular_velocity_radps);
  reader.number("mass_kg", kMass, definition.mass_kg);
  parse_inertia(reader, definition);
  reader.bits("group", definition.group);
  reader.bits("collides_with", definition.collides_with);
  reader.number("importance", kImportance, definition.importance);
  check_static(reader, plane, body);
  scene.bodies.push_back(std::move(body));
}

}  // namespace

void parse_materials(const JsonValue& value, Problems& problems, Scene& scene) {
  if (value.kind() != JsonValue::Kind::Object || value.items().empty()) {
    problems.refuse("materials", value, "must be an object with at least one material");
    return;
  }
  for (std::size_t i = 0; i < value.items().size(); ++i) {
    const ObjectReader reader(value.items()[i], member_path("materials", value.keys()[i]), problems,
                              {"restitution", "friction", "density_kgpm3"});
    SceneMaterial made{std::string(value.keys()[i]), {}};
    reader.number("restitution", kFactor, made.material.restitution);
    reader.number("friction", kFriction, made.material.friction);
    reader.number("density_kgpm3", kDensity, made.material.density_kgpm3);
    scene.materials.push_back(std::move(made));
  }
}

void parse_shapes(const JsonValue& value, Problems& problems, Scene& scene) {
  if (value.kind() != JsonValue::Kind::Object || value.items().empty()) {
    problems.refuse("shapes", value, "must be an object with at least one shape");
    return;
  }
  for (std::size_t i = 0; i < value.items().size(); ++i) {
    const JsonValue& item = value.items()[i];
    const std::string path = member_path("shapes", value.keys()[i]);
    const ObjectReader reader(item, path, problems, {"sphere", "plane", "mesh", "spheres", "tree"});
    if (item.kind() == JsonValue::Kind::Object && item.items().size() != 1) {
      problems.refuse(path, "must have exactly one of sphere, plane, mesh, spheres, tree");
    }
    SceneShape shape;
    shape.name = value.keys()[i];
    if (const JsonValue* sphere = reader.find("sphere")) parse_sphere(*sphere, reader.path("sphere"), problems, shape);
    if (const JsonValue* plane = reader.find("plane")) parse_plane(*plane, reader.path("plane"), problems, shape);
    if (const JsonValue* mesh = reader.find("mesh")) parse_mesh(*mesh, reader.path("mesh"), problems, shape);
    if (const JsonValue* spheres = reader.find("spheres"))
      parse_spheres(*spheres, reader.path("spheres"), problems, shape);
    if (const JsonValue* tree = reader.find("tree")) parse_tree(*tree, reader.path("tree"), problems, shape);
    scene.shapes.push_back(std::move(shape));
  }
}

void parse_bodies(const JsonValue& value, Problems& problems, const SceneNames& names, Scene& scene) {
  if (value.kind() != JsonValue::Kind::Array) {
    problems.refuse("bodies", value, "must be a list");
    return;
  }
  for (std::size_t i = 0; i < value.items().size(); ++i) {
    parse_body(value.items()[i], item_path("bodies", i), problems, names, scene);
  }
}

void parse_policy(const JsonValue& value, Problems& problems, scheduler::Policy& policy) {
  std::vector<std::string_view> known{"kind"};
  for (const scheduler::PolicyField& field : scheduler::policy_weights()) known.push_back(field.name);
  for (const scheduler::PolicyField& field : scheduler::policy_parameters()) known.push_back(field.name);
  for (const scheduler::PolicyCount& field : scheduler::policy_counts()) known.push_back(field.name);
  const ObjectReader reader(value, "policy", problems, known);
  const JsonValue* kind = reader.find("kind");
  if (kind != nullptr && kind->kind() == JsonValue::Kind::String && kind->text() == "custom") {
    problems.refuse("policy.kind", *kind,
                    fmt::format("is for programs that hand the World a function of their own; a scene file may say {}",
                                fmt::join(kPolicyNames, ", ")));
  } else {
    std::size_t named = 0;
    for (std::size_t k = 0; k < kPolicies.size(); ++k) named = kPolicies[k].kind == policy.kind ? k : named;
    reader.one_of("kind", {kPolicyNames.begin(), kPolicyNames.end()}, named);
    policy.kind = kPolicies[named].kind;
  }
  for (const auto& fields : {scheduler::policy_weights(), scheduler::policy_parameters()}) {
    for (const scheduler::PolicyField& field : fields)
      reader.number(field.name, Range{field.least, field.most, false}, policy.*field.value);
  }
  for (const scheduler::PolicyCount& field : scheduler::policy_counts()) {
    std::uint64_t count = policy.*field.value;
    reader.whole(field.name, field.least, field.most, count);
    policy.*field.value = static_cast<std::uint32_t>(count);
  }
}

}  // namespace poise::io
