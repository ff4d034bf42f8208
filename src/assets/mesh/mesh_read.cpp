// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "assets/mesh/mesh_counts.h"
#include "assets/mesh/mesh_files.h"
#include "geometry/primitives/rounding.h"
#include "poise/assets/mesh_file.h"
#include "poise/mesh.h"

namespace poise {
namespace {

namespace fs = std::filesystem;

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// Why the file cannot be read; empty if it can.
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

std::string whole_file(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// Text without a byte order mark, with two-byte text converted to one byte: only ASCII is needed, other characters
/// become '?'.
std::string plain_text(std::string text) {
  if (text.starts_with("\xef\xbb\xbf")) return text.substr(3);
  const bool big_end_first = text.starts_with("\xfe\xff");
  if (!big_end_first && !text.starts_with("\xff\xfe")) return text;
  std::string plain;
  plain.reserve(text.size() / 2);
  for (std::size_t i = 2; i + 1 < text.size(); i += 2) {
    const char high = text[big_end_first ? i : i + 1];
    const char low = text[big_end_first ? i + 1 : i];
    plain += high == 0 && static_cast<unsigned char>(low) < 0x80 ? low : '?';
  }
  return plain;
}

std::string why_no_triangle(std::size_t vertices) {
  if (vertices == 0) return "has no triangle, and no vertex either";
  return fmt::format("has no triangle: {} vertices, but no face with three corners; points and lines have no surface",
                     vertices);
}

Result<TriangleMesh> read_unscaled(const fs::path& file) {
  const std::string extension = lower_extension(file);
  if (extension == ".obj") return geometry::parse_obj(plain_text(whole_file(file)));
  if (extension == ".gltf" || extension == ".glb") {
    const Result<std::string> plain = geometry::plain_gltf(whole_file(file), file.parent_path());
    if (!plain) return plain.error();
    return geometry::import_gltf_with_assimp(plain.value());
  }
  std::string wrong;
  if (extension == ".off") wrong = geometry::wrong_off_counts(start_of(file), fs::file_size(file));
  if (extension == ".ply") wrong = geometry::wrong_ply_counts(start_of(file), fs::file_size(file));
  if (!wrong.empty()) return bad_input(std::move(wrong));
  for (const char* known : {".stl", ".ply", ".off"}) {
    if (extension == known) return geometry::import_with_assimp(file);
  }
  return bad_input(
      fmt::format("extension '{}' is not known, must be one of .obj .stl .ply .off .gltf .glb", extension));
}

}  // namespace

Result<TriangleMesh> read_mesh(const fs::path& file, const MeshReadOptions& options, MeshRepair* repair) {
  const auto refuse = [&](const std::string& rule) { return bad_input(fmt::format("{}: {}", file.string(), rule)); };
  if (!(options.scale > 0) || !std::isfinite(options.scale))
    return refuse(fmt::format("scale = {}, must be finite and > 0", options.scale));
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
        return refuse(fmt::format("vertex {} is at ({}, {}, {}) m, must be finite and within {} m", i, v.x(), v.y(),
                                  v.z(), geometry::kLargestLength_m));
      }
    }
    if (mesh.triangles.empty()) return refuse(why_no_triangle(mesh.vertices_m.size()));
    const MeshRepair done = clean_mesh(mesh, options.weld_relative);
    if (repair != nullptr) *repair = done;
    if (mesh.triangles.empty()) return refuse("has no triangle with three corners apart, at least one is needed");
    if (mesh.diagonal_m() < geometry::kSmallestLength_m) {
      return refuse(
          fmt::format("is {} m across, must be at least {} m", mesh.diagonal_m(), geometry::kSmallestLength_m));
    }
    return mesh;
  } catch (const std::exception& failure) {
    return refuse(failure.what());
  }
}

}  // namespace poise
