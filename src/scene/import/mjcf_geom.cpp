// SPDX-License-Identifier: MIT
#include "scene/import/mjcf_geom.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "assets/files/text_words.h"
#include "assets/tree/tree_files.h"
#include "scene/import/mjcf_attributes.h"

namespace poise::io {
namespace {

constexpr double kLeastHalf_m = 1e-9;
// Of a material of a scene.
constexpr double kMostFriction = 1e6;

struct GeomKind {
  std::string_view name;
  SolidKind kind;
  std::size_t sizes;  ///< how many numbers `size` must have
  bool from_to;       ///< whether fromto may stand for the last of them
};
constexpr std::array kGeomKinds{
    GeomKind{"sphere", SolidKind::Sphere, 1, false},      GeomKind{"capsule", SolidKind::Capsule, 2, true},
    GeomKind{"cylinder", SolidKind::Cylinder, 2, true},   GeomKind{"box", SolidKind::Box, 3, true},
    GeomKind{"ellipsoid", SolidKind::Ellipsoid, 3, true},
};

/// Places a geom between two points: its axis lies along them, and its half length is half their distance.
Status read_from_to(const MjcfView& view, const GeomKind& kind, DraftSolid& solid) {
  std::array<double, 6> ends{};
  const Status read = view.numbers("fromto", ends);
  if (!read) return read;
  const Vec3 from(ends[0], ends[1], ends[2]);
  const Vec3 to(ends[3], ends[4], ends[5]);
  const double half = 0.5 * (to - from).norm();
  if (!(half >= kLeastHalf_m)) return view.refused("fromto", "must be two points apart");
  solid.position_m = 0.5 * (from + to);
  solid.orientation = mjcf_turn_of_z(from - to);
  if (kind.sizes == 3) solid.half_m = {solid.half_m.x(), solid.half_m.x(), half};
  if (kind.sizes == 2) solid.half_m.y() = half;
  return Done{};
}

Status read_size(const MjcfView& view, const GeomKind& kind, DraftSolid& solid) {
  std::array<double, 3> size{};
  std::size_t count = 0;
  const bool from_to = view.find("fromto") != nullptr;
  if (from_to && !kind.from_to) return view.refused("fromto", fmt::format("has no meaning for a {}", kind.name));
  const std::size_t needed = from_to ? 1 : kind.sizes;
  const Status read = view.numbers("size", 1, size, count);
  if (!read) return read;
  const bool positive = std::all_of(size.begin(), size.begin() + static_cast<std::ptrdiff_t>(needed),
                                    [](double half) { return half >= kLeastHalf_m; });
  if (count < needed || !positive)
    return view.refused("size", fmt::format("of a {} must be {} number{}, at least {}", kind.name, needed,
                                            needed == 1 ? "" : "s", kLeastHalf_m));
  solid.half_m = Vec3::Zero();
  for (std::size_t i = 0; i < needed; ++i) solid.half_m[static_cast<Eigen::Index>(i)] = size[i];
  return from_to ? read_from_to(view, kind, solid) : Status(Done{});
}

/// Contacts and mass.
Status read_material(const MjcfView& view, MjcfGeom& geom) {
  std::array<double, 3> friction{1, 0, 0};
  std::size_t count = 0;
  std::uint64_t condim = 3;
  Status read = view.numbers("friction", 1, friction, count);
  if (read) read = view.whole("condim", 6, condim);
  if (read) read = view.whole("contype", std::numeric_limits<std::uint32_t>::max(), geom.contype);
  if (read) read = view.whole("conaffinity", std::numeric_limits<std::uint32_t>::max(), geom.conaffinity);
  if (read) read = view.numbers("mass", {&geom.mass_kg, 1});
  if (read) read = view.numbers("density", {&geom.density_kgpm3, 1});
  if (!read) return read;
  if (condim != 1 && condim != 3 && condim != 4 && condim != 6) return view.refused("condim", "must be 1, 3, 4 or 6");
  if (!(friction[0] >= 0 && friction[0] <= kMostFriction))
    return view.refused("friction", fmt::format("must be from 0 to {}", kMostFriction));
  if (view.find("mass") != nullptr && geom.mass_kg < 0) return view.refused("mass", "must be at least 0");
  if (geom.density_kgpm3 < 0) return view.refused("density", "must be at least 0");
  geom.friction = condim == 1 ? 0 : friction[0];
  return Done{};
}

Result<bool> read_solid(const MjcfView& view, const MjcfSettings& settings, UnmodelledKinds& unmodelled,
                        MjcfGeom& geom) {
  const char* type = view.find("type");
  const std::string_view kind = type != nullptr ? type : "sphere";
  geom.plane = kind == "plane";
  if (geom.plane) return true;
  const char* mesh = view.find("mesh");
  const auto known = std::ranges::find(kGeomKinds, kind, &GeomKind::name);
  if (kind == "mesh") {
    if (mesh == nullptr) return bad_input(view.place() + ": mesh must name a mesh of <asset>");
    const auto found = settings.meshes.find(std::string_view(mesh));
    if (found == settings.meshes.end()) return view.refused("mesh", "must be the name of a mesh of <asset>");
    geom.solid.kind = SolidKind::Mesh;
    geom.solid.mesh = found->second;
    if (geom.solid.mesh != std::numeric_limits<std::size_t>::max()) return true;
    unmodelled.add("geom of such a mesh", view.document->line(*view.element));
    return false;
  }
  if (known == kGeomKinds.end()) {
    if (kind != "hfield" && kind != "sdf")
      return view.refused("type", "must be plane, sphere, capsule, ellipsoid, cylinder, box, mesh, hfield or sdf");
    if (geom.collides()) unmodelled.add(fmt::format("geom of type {}", kind), view.document->line(*view.element));
    return false;
  }
  if (mesh != nullptr) {
    unmodelled.add(fmt::format("{} fitted to a mesh", kind), view.document->line(*view.element));
    return false;
  }
  geom.solid.kind = known->kind;
  const Status read = read_size(view, *known, geom.solid);
  if (!read) return read.error();
  return true;
}

/// Words of a list of numbers that are not bounded in count.
template <class Take>
Status each_number(const MjcfView& view, std::string_view name, std::string_view rule, Take&& take) {
  std::string line(view.find(name));
  std::ranges::replace(line, '\n', ' ');
  for (const std::string_view word : geometry::words_of(line)) {
    double number = 0;
    if (!geometry::read_number(word, number) || !take(number))
      return view.refused(name, fmt::format("has '{}', must have {}", mjcf_shown(word), rule));
  }
  return Done{};
}

Status read_own_faces(const MjcfView& view, TriangleMesh& mesh) {
  std::vector<double> coordinates;
  std::vector<std::uint32_t> corners;
  Status read = each_number(view, "vertex", "numbers within 1e9", [&](double number) {
    coordinates.push_back(number);
    return number >= -1e9 && number <= 1e9;
  });
  if (read && (coordinates.empty() || coordinates.size() % 3 != 0))
    read = view.refused("vertex", "must be three numbers for each vertex");
  const std::size_t vertices = coordinates.size() / 3;
  if (read)
    read = each_number(view, "face", fmt::format("whole numbers below {}, of vertices", vertices), [&](double number) {
      if (!(number >= 0 && number < static_cast<double>(vertices))) return false;
      corners.push_back(static_cast<std::uint32_t>(number));
      return static_cast<double>(corners.back()) == number;
    });
  if (read && (corners.empty() || corners.size() % 3 != 0))
    read = view.refused("face", "must be three vertices for each triangle");
  if (!read) return read;
  for (std::size_t i = 0; i < coordinates.size(); i += 3)
    mesh.vertices_m.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
  for (std::size_t i = 0; i < corners.size(); i += 3)
    mesh.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  return Done{};
}

}  // namespace

double MjcfGeom::known_mass_kg() const {
  if (mass_kg >= 0) return mass_kg;
  return solid.kind == SolidKind::Mesh ? -1 : density_kgpm3 * volume_of(solid);
}

Result<bool> read_mjcf_geom(const MjcfView& view, const MjcfSettings& settings, UnmodelledKinds& unmodelled,
                            MjcfGeom& geom) {
  note_mjcf_attributes(view, unmodelled);
  if (const char* name = view.element->Attribute("name")) geom.name = name;
  Status read = view.numbers("pos", {geom.solid.position_m.data(), 3});
  if (read) read = mjcf_orientation(view, settings.angles, geom.solid.orientation);
  if (read) read = read_material(view, geom);
  if (!read) return read.error();
  return read_solid(view, settings, unmodelled, geom);
}

Status read_mjcf_mesh(const MjcfView& view, MjcfSettings& settings, UnmodelledKinds& unmodelled, SceneDraft& draft) {
  note_mjcf_attributes(view, unmodelled);
  DraftMesh mesh;
  const char* file = view.element->Attribute("file");
  const char* name = view.element->Attribute("name");
  const bool vertices = view.element->Attribute("vertex") != nullptr;
  if ((file == nullptr || *file == '\0') && !vertices)
    return bad_input(view.place() + ": must have a file or a list of vertices");
  if (name != nullptr) {
    mesh.name = name;
  } else if (file != nullptr) {
    mesh.name = std::filesystem::path(file).stem().string();
  }
  if (mesh.name.empty()) return bad_input(view.place() + ": must have a name");
  Vec3 scale = Vec3::Ones();
  Status read = view.numbers("scale", {scale.data(), 3});
  if (!read) return read;
  mesh.linear = scale.asDiagonal();
  if (!(scale.cwiseAbs().minCoeff() >= kLeastHalf_m)) return view.refused("scale", "must not be 0");
  bool modelled = true;
  const std::string line = view.document->line(*view.element);
  if (view.element->Attribute("refpos") != nullptr || view.element->Attribute("refquat") != nullptr) {
    unmodelled.add("mesh with refpos or refquat", line);
    modelled = false;
  } else if (vertices && view.element->Attribute("face") == nullptr) {
    unmodelled.add("mesh of vertices alone, whose hull is meant", line);
    modelled = false;
  } else if (vertices) {
    TriangleMesh own;
    read = read_own_faces(view, own);
    if (!read) return read;
    mesh.mesh = std::make_shared<const TriangleMesh>(std::move(own));
  } else {
    const std::filesystem::path path(file);
    mesh.file = settings.mesh_folder / (settings.file_names_only ? path.filename() : path);
  }
  const std::size_t index = modelled ? draft.meshes.size() : std::numeric_limits<std::size_t>::max();
  if (!settings.meshes.emplace(mesh.name, index).second)
    return bad_input(fmt::format("{}: name '{}' is that of another mesh", view.place(), mjcf_shown(mesh.name)));
  if (modelled) draft.meshes.push_back(std::move(mesh));
  return Done{};
}

}  // namespace poise::io
