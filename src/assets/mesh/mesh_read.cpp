// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "assets/files/text_cursor.h"
#include "assets/files/text_file.h"
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

/// Chosen: so that vertices have numbers of 32 bits.
constexpr std::uint64_t kMostFileBytes = std::uint64_t{4} << 30U;

/// Whether a text begins with the mark of two-byte characters, of either order.
bool is_wide(std::string_view text) { return text.starts_with("\xfe\xff") || text.starts_with("\xff\xfe"); }

/// Two-byte text as one-byte text: only ASCII is needed, other characters become '?'.
std::string narrowed(std::string_view text) {
  const bool big_end_first = text.starts_with("\xfe\xff");
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

/// The formats by extension; the reader of glTF is another, since it reads more files.
struct Format {
  std::string_view extension;
  Result<TriangleMesh> (*parse)(std::string_view bytes);
};
constexpr std::array kFormats{
    Format{".obj", geometry::parse_obj},
    Format{".stl", geometry::parse_stl},
    Format{".ply", geometry::parse_ply},
    Format{".off", geometry::parse_off},
    Format{".gltf", nullptr},
    Format{".glb", nullptr},
};

Result<TriangleMesh> read_unscaled(const fs::path& file) {
  const std::string extension = lower_extension(file);
  const auto format = std::ranges::find(kFormats, extension, &Format::extension);
  if (format == kFormats.end())
    return bad_input(
        fmt::format("extension '{}' is not known, must be one of .obj .stl .ply .off .gltf .glb", extension));
  Result<std::string> read = geometry::read_bytes(file, kMostFileBytes);
  if (!read) return read.error();
  if (read.value().empty()) return bad_input("is empty");
  if (format->parse == nullptr) return geometry::parse_gltf(read.value(), file.parent_path());
  const bool is_text = extension == ".obj" || extension == ".off";
  if (!is_text) return format->parse(read.value());
  if (is_wide(read.value())) return format->parse(narrowed(read.value()));
  return format->parse(geometry::without_byte_order_mark(read.value()));
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
