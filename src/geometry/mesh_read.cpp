// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "geometry/mesh_counts.h"
#include "geometry/mesh_files.h"
#include "geometry/rounding.h"
#include "poise/mesh.h"

namespace poise {
namespace {

namespace fs = std::filesystem;

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// Empty when the file can be read.
std::string why_unreadable(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) return "cannot be read: no such file";
  if (!fs::is_regular_file(status)) return "cannot be read: not a file";
  const auto size = fs::file_size(file, error);
  if (!error && size == 0) return "is empty";
  return std::ifstream(file, std::ios::binary) ? std::string() : "cannot be read: no permission";
}

/// The first bytes of a file, enough for any header.
std::string start_of(const fs::path& file) {
  std::string start(65536, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(stream.gcount()));
  return start;
}

Result<TriangleMesh> read_unscaled(const fs::path& file) {
  const std::string extension = lower_extension(file);
  if (extension == ".obj") {
    std::ifstream stream(file, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    return geometry::parse_obj(text);
  }
  std::string wrong;
  if (extension == ".off") wrong = geometry::wrong_off_counts(start_of(file), fs::file_size(file));
  if (extension == ".ply") wrong = geometry::wrong_ply_counts(start_of(file), fs::file_size(file));
  if (!wrong.empty()) return bad_input(std::move(wrong));
  for (const char* known : {".stl", ".ply", ".off", ".gltf", ".glb"}) {
    if (extension == known) return geometry::import_with_assimp(file);
  }
  return bad_input(fmt::format("extension '{}' is not known, must be one of .obj .stl .ply .off .gltf .glb", extension));
}

}  // namespace

Result<TriangleMesh> read_mesh(const fs::path& file, const MeshReadOptions& options, MeshRepair* repair) {
  const auto refuse = [&](const std::string& rule) { return bad_input(fmt::format("{}: {}", file.string(), rule)); };
  if (!(options.scale > 0) || !std::isfinite(options.scale)) return refuse(fmt::format("scale = {}, must be finite and > 0", options.scale));
  if (!(options.weld_relative >= 0 && options.weld_relative <= 0.1)) {
    return refuse(fmt::format("weld_relative = {}, must be from 0 to 0.1", options.weld_relative));
  }
  try {
    if (const std::string wrong = why_unreadable(file); !wrong.empty()) return refuse(wrong);
    Result<TriangleMesh> read = read_unscaled(file);
    if (!read) return refuse(read.error().message);
    TriangleMesh mesh = std::move(read).value();
    for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
      Vec3& v = mesh.vertices_m[i];
      v *= options.scale;
      if (!v.allFinite() || v.cwiseAbs().maxCoeff() > geometry::kLargestLength_m) {
        return refuse(fmt::format("vertex {} is at ({}, {}, {}) m, must be finite and within {} m", i, v.x(), v.y(), v.z(),
                                  geometry::kLargestLength_m));
      }
    }
    const MeshRepair done = clean_mesh(mesh, options.weld_relative);
    if (repair != nullptr) *repair = done;
    if (mesh.triangles.empty()) return refuse("has no triangle with an area, at least one is needed");
    if (mesh.diagonal_m() < geometry::kSmallestLength_m) {
      return refuse(fmt::format("is {} m across, must be at least {} m", mesh.diagonal_m(), geometry::kSmallestLength_m));
    }
    return mesh;
  } catch (const std::exception& failure) {
    return refuse(failure.what());
  }
}

}  // namespace poise
