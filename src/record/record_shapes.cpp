// SPDX-License-Identifier: MIT
#include "record/record_shapes.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <limits>
#include <string>

#include "assets/files/text_file.h"
#include "assets/json/json_document.h"

namespace poise::io {
namespace {

// Hash of the data that determines motion. Each array begins with its length, so that no two shapes give the same
// input.
class Sum {
 public:
  template <class T>
  void add(const std::vector<T>& values, std::size_t count) {
    number(count);
    if (count > 0) hash_ = XXH64(values.data(), count * sizeof(T), hash_);
  }
  void number(std::uint64_t value) { hash_ = XXH64(&value, sizeof(value), hash_); }
  void number(double value) { hash_ = XXH64(&value, sizeof(value), hash_); }
  void vector(const Vec3& v) {
    for (const double value : {v.x(), v.y(), v.z()}) number(value);
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0;
};

std::uint64_t hash_of(const Shape& shape) {
  Sum sum;
  const SphereTree& tree = shape.tree;
  const std::size_t nodes = tree.node_count();
  sum.number(static_cast<std::uint64_t>(shape.kind));
  for (const auto* array :
       {&tree.x_m, &tree.y_m, &tree.z_m, &tree.radius_m, &tree.protrusion_max_m, &tree.protrusion_mean_m})
    sum.add(*array, nodes);
  sum.add(tree.fit, nodes);
  sum.add(tree.first_child, nodes);
  sum.add(tree.child_count, nodes);
  sum.add(tree.level_begin, tree.level_begin.size());
  for (const double value : {shape.bounding_radius_m, shape.volume_m3, shape.plane_offset_m}) sum.number(value);
  for (const Vec3& v :
       {shape.origin_offset_m, shape.principal_m5, shape.plane_normal, Vec3(shape.principal_axes.vec())})
    sum.vector(v);
  sum.number(shape.principal_axes.w());
  sum.number(std::uint64_t{shape.surface ? 1U : 0U});
  return sum.value();
}

std::vector<std::string> files_of(const SceneShape& shape) {
  std::vector<std::string> files;
  if (const auto* mesh = std::get_if<MeshSource>(&shape.source)) files.push_back(mesh->file.string());
  if (const auto* tree = std::get_if<TreeSource>(&shape.source)) {
    files.push_back(tree->file.string());
    if (!tree->mesh.empty()) files.push_back(tree->mesh.string());
  }
  return files;
}

Result<RecordedFile> read_again(const Scene& scene, const std::string& file) {
  const std::filesystem::path path =
      std::filesystem::path(file).is_absolute() ? std::filesystem::path(file) : scene.base / file;
  const Result<std::string> bytes = geometry::read_text_file(path, std::numeric_limits<std::uint64_t>::max());
  if (!bytes) return bytes.error();
  return RecordedFile{file, bytes.value().size(), XXH64(bytes.value().data(), bytes.value().size(), 0)};
}

std::string name_of(const Scene& scene, std::size_t shape) {
  return shape < scene.shapes.size() ? scene.shapes[shape].name : fmt::format("tray {}", shape - scene.shapes.size());
}

}  // namespace

Result<std::vector<RecordedShape>> recorded_shapes(const Scene& scene, std::span<const ShapePtr> shapes) {
  std::vector<RecordedShape> recorded(shapes.size());
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    recorded[i].name = name_of(scene, i);
    recorded[i].hash = hash_of(*shapes[i]);
    if (i >= scene.shapes.size()) continue;
    for (const std::string& file : files_of(scene.shapes[i])) {
      Result<RecordedFile> read = read_again(scene, file);
      if (!read) return read.error();
      recorded[i].files.push_back(std::move(read).value());
    }
  }
  return recorded;
}

Status check_files(const Scene& scene, std::span<const RecordedShape> recorded) {
  for (std::size_t i = 0; i < scene.shapes.size() && i < recorded.size(); ++i) {
    for (const RecordedFile& was : recorded[i].files) {
      const Result<RecordedFile> is = read_again(scene, was.path);
      const std::string place = scene.source + ": " + member_path("shapes", scene.shapes[i].name);
      if (!is) return bad_input(place + ": " + is.error().message);
      if (is.value().hash == was.hash && is.value().bytes == was.bytes) continue;
      return bad_input(
          fmt::format("{}: {} is another file than when the run was recorded: {} bytes, xxHash64 {:016x}, must be {} "
                      "bytes, {:016x}",
                      place, (scene.base / was.path).string(), is.value().bytes, is.value().hash, was.bytes, was.hash));
    }
  }
  return Done{};
}

Status check_shapes(const Scene& scene, std::span<const ShapePtr> shapes, std::span<const RecordedShape> recorded) {
  if (shapes.size() != recorded.size()) {
    return bad_input(fmt::format("{}: has {} shapes, the record has {}", scene.source, shapes.size(), recorded.size()));
  }
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const std::uint64_t hash = hash_of(*shapes[i]);
    if (hash == recorded[i].hash) continue;
    return bad_input(
        fmt::format("{}: {}: its sphere tree or mass comes out as {:016x}, the record has {:016x}: this program builds "
                    "shapes otherwise than the one "
                    "that recorded",
                    scene.source, member_path("shapes", name_of(scene, i)), hash, recorded[i].hash));
  }
  return Done{};
}

}  // namespace poise::io
