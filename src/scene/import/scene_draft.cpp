// SPDX-License-Identifier: MIT
#include "scene/import/scene_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "assets/files/atomic_file.h"
#include "geometry/mesh/solids.h"
#include "math/functions.h"
#include "poise/assets/mesh_file.h"
#include "poise/scene/scene.h"

namespace poise::io {
namespace {

namespace fs = std::filesystem;
using DraftJson = nlohmann::ordered_json;

constexpr double kMostCoordinate_m = 1e9;
constexpr double kLeastDiagonal_m = 1e-9;
// As files of meshes are read (MeshReadOptions).
constexpr double kWeldRelative = 1e-6;
// A program may have a thousand files open.
constexpr std::size_t kMeshesAtOnce = 256;

std::string line_of(const DraftJson& json) { return json.dump(-1, ' ', false, DraftJson::error_handler_t::replace); }

DraftJson vector_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// Every digit that the doubles have, so that what is read back is what was made.
std::string exact_obj_text(const TriangleMesh& mesh) {
  std::string text;
  for (const Vec3& v : mesh.vertices_m) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const auto& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

/// A shape that a body uses, and where the body's frame is in the shape's.
struct UsedShape {
  std::string name;
  Vec3 position_m = Vec3::Zero();  ///< of the shape in the frame of the body
  Quat orientation = Quat::Identity();
};

/// Makes the scene file's members one body after the other. Invariant: `shapes_` has each shape once.
class DraftWriter {
 public:
  DraftWriter(const SceneDraft& draft, const DraftSettings& settings, const fs::path& file, const SaveMesh& save,
              WrittenDraft& written)
      : draft_(draft),
        settings_(settings),
        save_(save),
        written_(written),
        folder_(file.parent_path()),
        mesh_folder_(file.stem().string() + "-meshes"),
        told_(draft.meshes.size(), false) {
    std::error_code unknown;
    for (const DraftMesh& mesh : draft.meshes)
      if (!mesh.file.empty()) inputs_.insert(fs::weakly_canonical(mesh.file, unknown).string());
  }

  Status add(const DraftBody& body) {
    const Result<UsedShape> shape = shape_of(body);
    if (!shape) return shape.error();
    DraftJson json;
    if (!body.name.empty()) json["name"] = body.name;
    json["shape"] = shape.value().name;
    json["material"] = material_of(body);
    if (!body.dynamic) json["static"] = true;
    json["position_m"] = vector_json(body.position_m + body.orientation * shape.value().position_m);
    const Quat turn = (body.orientation * shape.value().orientation).normalized();
    if (turn.vec().norm() > 0) json["orientation_wxyz"] = {turn.w(), turn.x(), turn.y(), turn.z()};
    if (body.dynamic && body.mass_kg > 0) json["mass_kg"] = body.mass_kg;
    if (body.group != 1) json["group"] = body.group;
    if (body.collides_with != 0xffffffffU) json["collides_with"] = body.collides_with;
    add_line(line_of(json), bodies_);
    return Done{};
  }

  /// A line for each material, shape and body.
  [[nodiscard]] std::string text() const {
    // Five seconds.
    const auto frames = static_cast<std::uint64_t>(std::clamp(std::ceil(5 / draft_.dt_s), 1.0, 1e6));
    return fmt::format(
        "{{\n \"name\": {},\n \"dt_s\": {},\n \"gravity_mps2\": {},\n \"frames\": {},\n"
        " \"materials\": {{\n{}\n }},\n \"shapes\": {{\n{}\n }},\n \"bodies\": [\n{}\n ]\n}}\n",
        line_of(draft_.name), line_of(draft_.dt_s), line_of(vector_json(draft_.gravity_mps2)), frames, materials_,
        shapes_, bodies_);
  }

 private:
  static void add_line(const std::string& line, std::string& lines) {
    if (!lines.empty()) lines += ",\n";
    lines += "  ";
    lines += line;
  }
  static void add_member(const std::string& name, const DraftJson& json, std::string& lines) {
    add_line(line_of(name) + ": " + line_of(json), lines);
  }

  std::string material_of(const DraftBody& body) {
    const auto [found, added] = material_names_.try_emplace({body.friction, body.density_kgpm3},
                                                            fmt::format("material-{}", material_names_.size() + 1));
    if (added)
      add_member(found->second, {{"friction", body.friction}, {"density_kgpm3", body.density_kgpm3}}, materials_);
    return found->second;
  }

  /// The name of the shape that `key` stands for; `make` makes it, and is called once for each key.
  template <class Make>
  Result<std::string> shared(const std::string& key, std::string_view kind, Make&& make) {
    const auto found = shape_names_.find(key);
    if (found != shape_names_.end()) return found->second;
    const std::string name = fmt::format("{}-{}", kind, ++counts_[std::string(kind)]);
    const Result<DraftJson> made = make(name);
    if (!made) return made.error();
    add_member(name, made.value(), shapes_);
    ++written_.shapes;
    shape_names_[key] = name;
    return name;
  }

  Result<UsedShape> shape_of(const DraftBody& body) {
    if (body.solids.empty()) {
      const Result<std::string> plane = shared("plane", "plane", [](const std::string&) {
        return Result<DraftJson>(DraftJson{{"plane", {{"normal", {0, 0, 1}}}}});
      });
      return named(plane, {});
    }
    if (body.solids.size() == 1) return single(body.solids.front());
    const bool balls =
        std::ranges::all_of(body.solids, [](const DraftSolid& s) { return s.kind == SolidKind::Sphere; });
    // Bodies that are alike share their shape.
    std::string key = "union";
    for (const DraftSolid& s : body.solids) key += key_of(s);
    return named(balls ? shared(key, "spheres", [&](const std::string&) { return union_of_balls(body); })
                       : shared(key, "union", [&](const std::string& name) { return union_mesh(body, name); }),
                 {});
  }

  /// Equal for solids that are equal to the bit.
  static std::string key_of(const DraftSolid& s) {
    const Quat& q = s.orientation;
    return fmt::format(" {} {} {} {} {} at {} {} {} {} {} {} {}", static_cast<int>(s.kind), s.mesh, s.half_m.x(),
                       s.half_m.y(), s.half_m.z(), s.position_m.x(), s.position_m.y(), s.position_m.z(), q.w(), q.x(),
                       q.y(), q.z());
  }

  static Result<UsedShape> named(const Result<std::string>& name, const DraftSolid& at) {
    if (!name) return name.error();
    return UsedShape{name.value(), at.position_m, at.orientation};
  }

  /// A solid alone has a shape in its own frame, which others of the same size share.
  Result<UsedShape> single(const DraftSolid& solid) {
    constexpr const char* kNames[] = {"sphere", "capsule", "cylinder", "ellipsoid", "box", "mesh"};
    const char* kind = kNames[static_cast<std::size_t>(solid.kind)];
    DraftSolid centered = solid;
    centered.position_m.setZero();
    centered.orientation.setIdentity();
    return named(shared(key_of(centered), kind,
                        [&](const std::string& name) -> Result<DraftJson> {
                          if (solid.kind == SolidKind::Sphere)
                            return DraftJson{{"sphere", {{"radius_m", solid.half_m.x()}}}};
                          if (solid.kind == SolidKind::Mesh) return own_mesh(solid.mesh, name);
                          const TriangleMesh mesh = solid_mesh(solid);
                          if (triangles_lost(mesh) > 0)
                            return bad_input(
                                fmt::format("a {} of half sizes {} m is too thin, must be thicker than "
                                            "{} of its diagonal",
                                            kind, vector_json(solid.half_m).dump(), kWeldRelative));
                          return saved_mesh(mesh, name, false);
                        }),
                 solid);
  }

  static Result<DraftJson> union_of_balls(const DraftBody& body) {
    DraftJson centers = DraftJson::array();
    DraftJson radii = DraftJson::array();
    for (const DraftSolid& solid : body.solids) {
      centers.push_back(vector_json(solid.position_m));
      radii.push_back(solid.half_m.x());
    }
    return DraftJson{{"spheres", {{"centers_m", std::move(centers)}, {"radii_m", std::move(radii)}}}};
  }

  Result<DraftJson> union_mesh(const DraftBody& body, const std::string& name) {
    TriangleMesh all;
    std::size_t shells = 0;
    std::vector<std::size_t> begins;
    for (const DraftSolid& solid : body.solids) {
      TriangleMesh part;
      if (solid.kind == SolidKind::Mesh) {
        Result<ReadMesh> read = read_draft_mesh(solid.mesh);
        if (!read) return read.error();
        if (read.value().shell) ++shells;
        part = std::move(read.value().mesh);
      } else {
        part = solid_mesh(solid);
      }
      const std::size_t triangles = all.triangles.size() + part.triangles.size();
      if (!room_for(triangles)) return too_many();
      if (triangles > settings_.most_of_mesh)
        return bad_input(fmt::format("body '{}' needs a mesh of more than {} triangles for its {} solids", body.name,
                                     settings_.most_of_mesh, body.solids.size()));
      const auto base = static_cast<std::uint32_t>(all.vertices_m.size());
      begins.push_back(base);
      for (const Vec3& v : part.vertices_m) all.vertices_m.emplace_back(solid.orientation * v + solid.position_m);
      for (const auto& t : part.triangles) all.triangles.push_back({base + t[0], base + t[1], base + t[2]});
    }
    // As one mesh of a thickness the solids would be hollow.
    if (shells > 0 && shells < body.solids.size())
      return bad_input(fmt::format(
          "body '{}' has meshes that enclose no volume ({}) beside solids ({}), must have solids alone or none",
          body.name, shells, body.solids.size() - shells));
    if (triangles_lost(all) > 0) part_solids(begins, all);
    return saved_mesh(all, name, shells > 0);
  }

  /// How many triangles are not read again where vertices are welded.
  static std::size_t triangles_lost(TriangleMesh mesh) { return clean_mesh(mesh, kWeldRelative).triangles_discarded; }

  /// Moves each solid of a union by a few millionths of its size, each somewhere else: of faces that lie on each other
  /// one would be taken for a repetition of the other, and a solid would be open. `begins` has their first vertices.
  static void part_solids(const std::vector<std::size_t>& begins, TriangleMesh& all) {
    constexpr double kGolden = 2.399963229728653;  // radians: no two directions are near each other
    const double step_m = 4 * kWeldRelative * all.diagonal_m();
    for (std::size_t k = 1; k < begins.size(); ++k) {
      const math::SinCos turn = math::sin_cos(kGolden * static_cast<double>(k));
      const double z = 1 - 2 * (static_cast<double>(k) + 0.5) / static_cast<double>(begins.size() + 1);
      const double across = std::sqrt(1 - z * z);
      const Vec3 moved = step_m * static_cast<double>(1 + k % 4) * Vec3(across * turn.cos, across * turn.sin, z);
      const std::size_t end = k + 1 < begins.size() ? begins[k + 1] : all.vertices_m.size();
      for (std::size_t v = begins[k]; v < end; ++v) all.vertices_m[v] += moved;
    }
  }

  /// A mesh of the draft: its own file where that has its size, else a new one.
  Result<DraftJson> own_mesh(std::size_t index, const std::string& name) {
    const Result<ReadMesh> read = read_draft_mesh(index);
    if (!read) return read.error();
    const DraftMesh& mesh = draft_.meshes[index];
    const double scale = mesh.linear(0, 0);
    if (mesh.file.empty() || !(scale > 0) || mesh.linear != Mat3(scale * Mat3::Identity()))
      return saved_mesh(read.value().mesh, name, read.value().shell);
    std::error_code failure;
    const fs::path relative = fs::proximate(fs::absolute(mesh.file, failure),
                                            fs::absolute(folder_.empty() ? "." : folder_, failure), failure);
    DraftJson json = {{"file", (failure ? mesh.file : relative).string()}, {"scale", scale}};
    return mesh_json(std::move(json), read.value().shell);
  }

  [[nodiscard]] bool room_for(std::size_t triangles) const { return triangles_ + triangles <= settings_.most_written; }
  [[nodiscard]] Error too_many() const {
    return bad_input(fmt::format("needs meshes of more than {} triangles", settings_.most_written));
  }

  Result<DraftJson> saved_mesh(const TriangleMesh& mesh, const std::string& name, bool shell) {
    if (!room_for(mesh.triangles.size())) return too_many();
    triangles_ += mesh.triangles.size();
    std::error_code failure;
    const fs::path file = fs::path(mesh_folder_) / (name + ".obj");
    if (inputs_.contains(fs::weakly_canonical(folder_ / file, failure).string()))
      return bad_input(
          fmt::format("would overwrite its mesh {}, the scene needs another name", (folder_ / file).string()));
    const Status saved = save_(folder_ / file, exact_obj_text(mesh));
    if (!saved) return saved.error();
    ++written_.mesh_files;
    return mesh_json({{"file", file.string()}}, shell);
  }

  Result<DraftJson> mesh_json(DraftJson json, bool shell) const {
    json["depth"] = settings_.depth;
    if (shell) json["shell_thickness_m"] = settings_.shell_thickness_m;
    return DraftJson{{"mesh", std::move(json)}};
  }

  struct ReadMesh {
    TriangleMesh mesh;  ///< in metres
    bool shell = false;
  };

  /// Reads a mesh of the draft and finds whether it encloses anything. It is not held, since many bodies may each have
  /// one of their own size.
  Result<ReadMesh> read_draft_mesh(std::size_t index) {
    const DraftMesh& draft = draft_.meshes[index];
    const auto refused = [&](const std::string& why) {
      return bad_input(fmt::format("mesh '{}': {}", draft.name, why));
    };
    ReadMesh read;
    if (draft.mesh != nullptr) {
      read.mesh = *draft.mesh;
    } else {
      Result<TriangleMesh> file = read_mesh(draft.file, {});
      if (!file) return refused(file.error().message);
      read.mesh = std::move(file).value();
    }
    read_ += read.mesh.vertices_m.size() + read.mesh.triangles.size();
    if (read_ > settings_.most_read)
      return bad_input(
          fmt::format("its meshes have more than {} vertices and triangles together, each as often as it is used",
                      settings_.most_read));
    for (Vec3& v : read.mesh.vertices_m) {
      v = draft.linear * v;
      if (!v.allFinite() || v.cwiseAbs().maxCoeff() > kMostCoordinate_m)
        return refused(fmt::format("has a vertex that is not within {} m", kMostCoordinate_m));
    }
    if (draft.linear.determinant() < 0)
      for (auto& t : read.mesh.triangles) std::swap(t[1], t[2]);
    if (draft.mesh != nullptr) clean_mesh(read.mesh, kWeldRelative);
    if (read.mesh.triangles.empty() || !(read.mesh.diagonal_m() >= kLeastDiagonal_m))
      return refused("has no triangle with three corners apart");
    const Result<MeshReport> report = assess_mesh(read.mesh);
    if (!report) return refused(report.error().message);
    read.shell = report.value().solidity == Solidity::Shell;
    if (read.shell && !told_[index])
      written_.warnings.push_back(one_line(fmt::format("mesh '{}' encloses no volume: it is its surface, {} m thick",
                                                       draft.name, settings_.shell_thickness_m)));
    told_[index] = told_[index] || read.shell;
    return read;
  }

  static TriangleMesh solid_mesh(const DraftSolid& solid) {
    const Vec3& h = solid.half_m;
    switch (solid.kind) {
      case SolidKind::Sphere:
        return geometry::ellipsoid_solid(Vec3::Constant(h.x()));
      case SolidKind::Capsule:
        return geometry::capsule_solid(h.x(), h.y());
      case SolidKind::Cylinder:
        return geometry::cylinder_solid(h.x(), h.y());
      case SolidKind::Ellipsoid:
        return geometry::ellipsoid_solid(h);
      case SolidKind::Box:
      case SolidKind::Mesh:
        break;
    }
    return geometry::box_solid(h);
  }

  const SceneDraft& draft_;
  const DraftSettings& settings_;
  const SaveMesh& save_;
  WrittenDraft& written_;
  fs::path folder_;
  std::string mesh_folder_;
  std::set<std::string> inputs_;  ///< mesh files of the model, which are not overwritten
  std::vector<bool> told_;        ///< beside draft_.meshes: a warning says that it is a shell
  std::size_t triangles_ = 0;     ///< that were written
  std::size_t read_ = 0;          ///< vertices and triangles
  std::map<std::pair<double, double>, std::string> material_names_;
  std::map<std::string, std::string> shape_names_;
  std::map<std::string, std::size_t> counts_;
  std::string materials_, shapes_, bodies_;  ///< a line each; members of JSON objects are found one by one
};

struct MeshText {
  fs::path file;
  std::string text;
};

// A file replaces another only when kMeshesAtOnce of them, or all, have reached the system.
Status write_meshes(std::span<const MeshText> meshes) {
  for (std::size_t begin = 0; begin < meshes.size(); begin += kMeshesAtOnce) {
    std::vector<geometry::AtomicFile> files;
    for (const MeshText& mesh : meshes.subspan(begin, std::min(kMeshesAtOnce, meshes.size() - begin))) {
      Result<geometry::AtomicFile> opened = geometry::AtomicFile::open(mesh.file);
      if (!opened) return opened.error();
      files.push_back(std::move(opened).value());
      Status saved = files.back().write(mesh.text);
      if (saved) saved = files.back().flush();
      if (!saved) return saved;
    }
    for (geometry::AtomicFile& mesh : files) {
      const Status named = mesh.commit();
      if (!named) return named;
    }
  }
  return Done{};
}

}  // namespace

double volume_of(const DraftSolid& solid) {
  const Vec3& h = solid.half_m;
  const double ball = 4.0 / 3 * std::numbers::pi;
  switch (solid.kind) {
    case SolidKind::Sphere:
      return ball * h.x() * h.x() * h.x();
    case SolidKind::Capsule:
      return ball * h.x() * h.x() * h.x() + 2 * std::numbers::pi * h.x() * h.x() * h.y();
    case SolidKind::Cylinder:
      return 2 * std::numbers::pi * h.x() * h.x() * h.y();
    case SolidKind::Ellipsoid:
      return ball * h.prod();
    case SolidKind::Box:
      return 8 * h.prod();
    case SolidKind::Mesh:
      break;
  }
  return 0;
}

Result<std::string> draft_text(const SceneDraft& draft, const DraftSettings& settings, const fs::path& file,
                               const SaveMesh& save, WrittenDraft& written) {
  if (draft.bodies.empty()) return bad_input("has no body with a shape that collides");
  DraftWriter writer(draft, settings, file, save, written);
  for (const DraftBody& body : draft.bodies) {
    const Status added = writer.add(body);
    if (!added) return added.error();
  }
  // It is a scene like any other, with its limits, before it takes the place of what was there.
  std::string text = writer.text();
  const Result<Scene> sound = parse_scene(text, file.string(), file.parent_path());
  if (!sound) return sound.error();
  return text;
}

Result<WrittenDraft> write_draft(const SceneDraft& draft, const DraftSettings& settings, const fs::path& file) {
  WrittenDraft written;
  // Meshes of a scene that was there before stay as they are until all is known to be sound, and the scene to have
  // room.
  std::vector<MeshText> meshes;
  const auto save = [&](const fs::path& mesh, const std::string& text) {
    meshes.push_back({mesh, text});
    return Status(Done{});
  };
  const Result<std::string> text = draft_text(draft, settings, file, save, written);
  if (!text) return text.error();
  Result<geometry::AtomicFile> scene = geometry::AtomicFile::open(file);
  if (!scene) return scene.error();
  Status saved = scene.value().write(text.value());
  if (saved) saved = scene.value().flush();
  std::error_code failure;
  const fs::path folder = meshes.empty() ? fs::path() : meshes.front().file.parent_path();
  const bool is_new = saved && !meshes.empty() && fs::create_directories(folder, failure);
  if (saved) saved = write_meshes(meshes);
  if (saved) saved = scene.value().commit();
  if (saved) return written;
  if (is_new) fs::remove(folder, failure);  // unless something is in it
  return saved.error();
}

}  // namespace poise::io
