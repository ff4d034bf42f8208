// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include <assimp/scene.h>
#include <fmt/format.h>
#include <assimp/Importer.hpp>

#include "assets/mesh/mesh_files.h"
#include "geometry/mesh/ear_clipping.h"

namespace poise::geometry {
namespace {

using Transform = Eigen::Matrix4d;

Transform to_transform(const aiMatrix4x4& m) {
  Transform t;
  t << static_cast<double>(m.a1), static_cast<double>(m.a2), static_cast<double>(m.a3), static_cast<double>(m.a4),
      static_cast<double>(m.b1), static_cast<double>(m.b2), static_cast<double>(m.b3), static_cast<double>(m.b4),
      static_cast<double>(m.c1), static_cast<double>(m.c2), static_cast<double>(m.c3), static_cast<double>(m.c4),
      static_cast<double>(m.d1), static_cast<double>(m.d2), static_cast<double>(m.d3), static_cast<double>(m.d4);
  return t;
}

std::string add_mesh(const aiMesh& source, const Transform& transform, TriangleMesh& mesh) {
  const std::size_t base = mesh.vertices_m.size();
  if (base + source.mNumVertices > 0xffffffffULL) return "more than 2^32 vertices";
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    const aiVector3D& v = source.mVertices[i];
    const Vec3 point(static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z));
    if (!point.allFinite())
      return fmt::format("vertex {} is ({}, {}, {}), must be finite", i, point.x(), point.y(), point.z());
    mesh.vertices_m.emplace_back((transform * point.homogeneous()).head<3>());
  }
  const bool mirrored = transform.topLeftCorner<3, 3>().determinant() < 0;
  std::vector<std::uint32_t> corners;
  for (unsigned f = 0; f < source.mNumFaces; ++f) {
    const aiFace& face = source.mFaces[f];
    corners.clear();
    for (unsigned i = 0; i < face.mNumIndices; ++i) {
      if (face.mIndices[i] >= source.mNumVertices) {
        return fmt::format("face {}: names vertex {} of {}, must exist", f, face.mIndices[i], source.mNumVertices);
      }
      corners.push_back(static_cast<std::uint32_t>(base + face.mIndices[i]));
    }
    if (mirrored) std::ranges::reverse(corners);
    triangulate_polygon(mesh.vertices_m, corners, mesh.triangles);
  }
  return {};
}

/// A library's message as one line.
std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text.substr(0, 300);
}

Result<TriangleMesh> merged(const aiScene* scene, const char* error) {
  if (scene == nullptr || scene->mRootNode == nullptr) return bad_input(one_line(error));
  TriangleMesh mesh;
  std::vector<std::pair<const aiNode*, Transform>> waiting{{scene->mRootNode, Transform::Identity()}};
  while (!waiting.empty()) {
    const auto [node, parent] = waiting.back();
    waiting.pop_back();
    const Transform transform = parent * to_transform(node->mTransformation);
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
      if (node->mMeshes[i] >= scene->mNumMeshes) return bad_input("a node names a mesh that does not exist");
      std::string wrong = add_mesh(*scene->mMeshes[node->mMeshes[i]], transform, mesh);
      if (!wrong.empty()) return bad_input(std::move(wrong));
    }
    for (unsigned i = node->mNumChildren; i > 0; --i) waiting.emplace_back(node->mChildren[i - 1], transform);
  }
  return mesh;
}

/// Calls read(importer) to load a scene, and merges its meshes. Without post-processing: some of its steps use indices
/// before anything has checked them.
template <class Read>
Result<TriangleMesh> import(Read&& read) {
  try {
    Assimp::Importer importer;
    const aiScene* scene = read(importer);
    return merged(scene, importer.GetErrorString());
  } catch (const std::exception& failure) {
    return bad_input(one_line(failure.what()));
  } catch (...) {
    return bad_input("the reader failed");
  }
}

}  // namespace

Result<TriangleMesh> import_with_assimp(const std::filesystem::path& file) {
  return import([&](Assimp::Importer& importer) { return importer.ReadFile(file.string(), 0); });
}

Result<TriangleMesh> import_gltf_with_assimp(const std::string& text) {
  Result<TriangleMesh> mesh = import(
      [&](Assimp::Importer& importer) { return importer.ReadFileFromMemory(text.data(), text.size(), 0, "gltf"); });
  // The library's message if it has skipped every face because of indices out of range.
  if (!mesh && mesh.error().message.ends_with("has no faces")) {
    return bad_input(mesh.error().message + " whose corners all exist");
  }
  return mesh;
}

}  // namespace poise::geometry
