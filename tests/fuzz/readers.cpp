// SPDX-License-Identifier: MIT
#include "fuzz/readers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/live/live_message.h"
#include "assets/cache/tree_cache_entry.h"
#include "assets/mesh/gltf_nodes.h"
#include "assets/mesh/mesh_files.h"
#include "assets/tree/tree_files.h"
#include "assets/tree/urdf_robot.h"
#include "fuzz/checks.h"
#include "fuzz/containers.h"
#include "poise/assets/sph_file.h"
#include "poise/scene/scene.h"
#include "record/record_bytes.h"
#include "record/record_file.h"
#include "scene/import/gltf_import.h"
#include "scene/import/mjcf_import.h"
#include "scene/import/scene_draft.h"
#include "scene/policy_file.h"
#include "scene/run/time_priors.h"

namespace poise::fuzz {
namespace {

bool read_scene_text(std::string_view bytes) {
  std::vector<std::string> errors;
  const Result<Scene> scene = parse_scene(bytes, "scene", ".", &errors);
  for (const std::string& error : errors) checked(bad_input(error));
  require(scene.ok() == errors.empty(), "a scene is refused with what is wrong");
  return checked(scene);
}

bool read_gaze(std::string_view bytes) { return checked(parse_gaze(bytes, "gaze", {1920, 1080})); }

bool read_obj(std::string_view bytes) { return checked_mesh(geometry::parse_obj(bytes)); }
bool read_off(std::string_view bytes) { return checked_mesh(geometry::parse_off(bytes)); }
bool read_stl(std::string_view bytes) { return checked_mesh(geometry::parse_stl(bytes)); }
bool read_ply(std::string_view bytes) { return checked_mesh(geometry::parse_ply(bytes)); }

/// A scene of what was imported: its text is read as a scene, or it is refused. Meshes are made and not kept.
void check_scene_of(const io::SceneDraft& imported) {
  // More are as these, and take the time of a hundred other cases.
  constexpr std::size_t kMostSolids = 20, kMostVertices = 10'000;
  std::size_t solids = 0;
  std::size_t vertices = 0;
  for (const io::DraftBody& body : imported.bodies) solids += body.solids.size();
  for (const io::DraftMesh& mesh : imported.meshes)
    if (mesh.mesh != nullptr) vertices += mesh.mesh->vertices_m.size() + mesh.mesh->triangles.size();
  if (solids > kMostSolids || vertices > kMostVertices) return;
  io::SceneDraft draft = imported;
  draft.name = "scene";
  io::WrittenDraft written;
  const auto save = [](const std::filesystem::path&, const std::string&) { return Status(Done{}); };
  const Result<std::string> text = io::draft_text(draft, {}, "scene.json", save, written);
  if (!checked(text)) return;
  require(parse_scene(text.value(), "scene", ".").ok(), "an imported scene is a scene");
  for (const std::string& warning : written.warnings) checked(bad_input(warning));
}

void check_gltf_nodes(std::string_view bytes) {
  Result<geometry::GltfNodes> nodes = geometry::parse_gltf_nodes(bytes, "/nowhere");
  if (!checked(nodes)) return;
  for (const TriangleMesh& mesh : nodes.value().meshes) checked_mesh(mesh);
  for (const geometry::GltfNode& node : nodes.value().nodes)
    require(node.mesh < nodes.value().meshes.size() && !node.name.empty(), "a node has a name and a mesh");
  io::GltfImportSettings settings;
  settings.floor = true;
  const Result<io::SceneDraft> draft = io::gltf_draft(std::move(nodes).value(), settings);
  if (checked(draft)) check_scene_of(draft.value());
}

bool read_gltf(std::string_view bytes) {
  check_gltf_nodes(bytes);
  return checked_mesh(geometry::parse_gltf(bytes, "/nowhere"));
}

bool read_sph_file(std::string_view bytes) {
  const MemoryFile file(bytes, "sph");
  return checked(read_sph(file.path()));
}

bool checked_spheres(const Result<std::vector<Sphere>>& spheres) {
  if (!spheres.ok()) return checked(spheres.error());
  require(spheres.value().size() <= kMaxUnionSpheres, "spheres are at most kMaxUnionSpheres");
  for (const Sphere& sphere : spheres.value())
    require(sphere.center_m.allFinite() && sphere.radius_m > 0, "a sphere is finite");
  return true;
}
bool read_urdf(std::string_view bytes) { return checked_spheres(geometry::urdf_spheres(std::string(bytes), {})); }
bool read_yaml(std::string_view bytes) { return checked_spheres(geometry::curobo_spheres(std::string(bytes), {})); }
bool read_foam(std::string_view bytes) { return checked_spheres(geometry::foam_spheres(std::string(bytes), {})); }

/// The links of a robot, and the robot with a sphere for each, which must be read as that.
bool read_robot(std::string_view bytes) {
  const std::string text(bytes);
  const Result<std::vector<geometry::UrdfLink>> links = geometry::urdf_links(text);
  if (!links) return checked(links.error());
  std::vector<std::optional<std::vector<Sphere>>> spheres;
  for (const geometry::UrdfLink& link : links.value()) {
    spheres.emplace_back();
    if (!link.parts.empty()) spheres.back().emplace({Sphere{Vec3::Zero(), 1}});
    for (const geometry::UrdfPart& part : link.parts)
      require(part.rotation.allFinite() && part.position_m.allFinite() && part.scale.allFinite(), "a pose is finite");
  }
  const Result<std::string> written = geometry::with_collision_spheres(text, spheres);
  if (!written) return checked(written.error());
  const Result<std::vector<geometry::UrdfLink>> again = geometry::urdf_links(written.value());
  require(again.ok() && again.value().size() == spheres.size(), "a robot with spheres is a robot");
  for (std::size_t i = 0; i < spheres.size(); ++i)
    require(!spheres[i] || (again.value()[i].only_spheres() && again.value()[i].parts.size() == 1),
            "a link has the spheres that it was given");
  return true;
}

/// A model of MuJoCo, with what is not modelled left out.
bool read_mjcf(std::string_view bytes) {
  const std::string text(bytes);
  checked(io::import_mjcf(text, "model", "/nowhere", false));
  const Result<io::SceneDraft> draft = io::import_mjcf(text, "model", "/nowhere", true);
  if (!draft) return checked(draft.error());
  for (const io::DraftBody& body : draft.value().bodies) {
    require(body.position_m.allFinite() && std::abs(body.orientation.norm() - 1) < 1e-9, "a pose is finite");
    require(std::isfinite(body.mass_kg) && body.mass_kg >= 0, "a mass is finite");
    for (const io::DraftSolid& solid : body.solids) {
      require(solid.position_m.allFinite() && solid.half_m.allFinite(), "a solid is finite");
      require(solid.kind != io::SolidKind::Mesh || solid.mesh < draft.value().meshes.size(), "a mesh exists");
    }
  }
  for (const io::DraftMesh& mesh : draft.value().meshes)
    if (mesh.mesh != nullptr) checked_mesh(*mesh.mesh);
  for (const std::string& warning : draft.value().warnings) checked(bad_input(warning));
  check_scene_of(draft.value());
  return true;
}

/// A whole record with its checksums put right, or one part of it: the first byte says which.
bool read_record(std::string_view bytes) {
  if (bytes.starts_with("poise.record/")) {
    const MemoryFile file(with_record_checksums(bytes), "record");
    Result<io::RecordReader> reader = io::RecordReader::open(file.path());
    if (!reader) return checked(reader.error());
    io::RecordedFrame frame;
    while (reader.value().next(frame) == io::RecordReader::Next::Frame) {
    }
    return !reader.value().damage().has_value();
  }
  if (bytes.empty()) return false;
  const std::string_view part = bytes.substr(1);
  io::RecordedFrame frame;
  io::RecordEnd end;
  if (bytes[0] == 'F') return checked(io::read_frame(part, frame));
  if (bytes[0] == 'E') return checked(io::read_end(part, end));
  return checked(io::read_header(part, "header"));
}

bool read_cache_entry(std::string_view bytes) {
  const geometry::TreeKey key{};
  const auto tree = geometry::entry_tree(with_entry_checksum(bytes), key);
  if (!tree) return false;
  require(geometry::entry_bytes(*tree, key) == with_entry_checksum(bytes), "an entry is its tree and nothing else");
  return true;
}

bool read_time_priors(std::string_view bytes) {
  const io::TimePriorsKey key{"machine", 2, 2, "tbb", "fitted", 0.01};
  return io::parse_time_priors(bytes, key).has_value();
}

bool read_policy(std::string_view bytes) {
  const MemoryFile file(bytes, "policy");
  return checked(io::read_policy_file(file.path(), {}));
}

bool read_live_message(std::string_view bytes) { return checked(app::parse_live_message(bytes)); }

constexpr std::array kReaders{
    Reader{"scene", read_scene_text},  Reader{"gaze", read_gaze},
    Reader{"obj", read_obj},           Reader{"off", read_off},
    Reader{"stl", read_stl},           Reader{"ply", read_ply},
    Reader{"gltf", read_gltf},         Reader{"sph", read_sph_file},
    Reader{"urdf", read_urdf},         Reader{"yaml", read_yaml},
    Reader{"foam", read_foam},         Reader{"record", read_record},
    Reader{"cache", read_cache_entry}, Reader{"priors", read_time_priors},
    Reader{"policy", read_policy},     Reader{"live", read_live_message},
    Reader{"robot", read_robot},       Reader{"mjcf", read_mjcf},
#ifdef POISE_FUZZ_CAPTURE
    Reader{"capture", read_capture},
#endif
#ifdef POISE_FUZZ_SWEEP
    Reader{"sweep", read_sweep_spec},  Reader{"trials", read_trials},
    Reader{"outcome", read_outcome},   Reader{"result", read_run_result},
#endif
};

}  // namespace

std::span<const Reader> readers() { return kReaders; }

const Reader* find_reader(std::string_view name) {
  const auto found = std::ranges::find(kReaders, name, &Reader::name);
  return found == kReaders.end() ? nullptr : &*found;
}

}  // namespace poise::fuzz
