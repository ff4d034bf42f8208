// SPDX-License-Identifier: MIT
#include "scene/scene_data.h"

#include <string>

#include <fmt/format.h>

#include "assets/json/json_document.h"
#include "scene/field_reader.h"

namespace poise::io {
namespace {

// The first problem that is found; empty while there is none.
class SceneData {
 public:
  explicit SceneData(const Scene& scene) : scene_(scene) {}

  void step() {
    if (!(scene_.dt_s > kTimeStep.min && scene_.dt_s <= kTimeStep.max))
      refuse("dt_s", fmt::format("{}", scene_.dt_s),
             fmt::format("must be > {} and <= {}", kTimeStep.min, kTimeStep.max));
    count("frames", scene_.frames, 1, kMaxSceneFrames);
  }
  void bodies() {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const std::string path = item_path("bodies", i);
      names(member_path(path, "shape"), scene_.bodies[i].shape, scene_.shapes.size(), "shapes");
      names(member_path(path, "material"), scene_.bodies[i].material, scene_.materials.size(), "materials");
    }
    if (scene_.tray) names("tray.material", scene_.tray->material, scene_.materials.size(), "materials");
  }
  void generators() {
    std::uint64_t sum = scene_.bodies.size();
    for (std::size_t i = 0; i < scene_.generators.size() && wrong_.empty(); ++i) {
      const auto* stream = std::get_if<StreamGenerator>(&scene_.generators[i]);
      const std::string path = member_path(item_path("generators", i), stream != nullptr ? "stream" : "grid");
      if (stream != nullptr) {
        kind(path, stream->kind);
        count(member_path(path, "total"), stream->total, 0, kMaxSceneBodies);
        sum += stream->total;
      } else {
        sum += grid(path, std::get<GridGenerator>(scene_.generators[i]));
      }
    }
    count("generators: the bodies of the scene", sum, 0, kMaxSceneBodies);
  }
  [[nodiscard]] Status status() && {
    return wrong_.empty() ? Status(Done{}) : bad_input(scene_.source + ": " + wrong_);
  }

 private:
  void refuse(const std::string& path, const std::string& value, const std::string& rule) {
    if (wrong_.empty()) wrong_ = fmt::format("{} = {}, {}", path, value, rule);
  }
  void count(const std::string& path, std::uint64_t value, std::uint64_t least, std::uint64_t most) {
    if (value < least || value > most)
      refuse(path, fmt::format("{}", value), fmt::format("must be from {} to {}", least, most));
  }
  void names(const std::string& path, std::size_t index, std::size_t items, const char* list) {
    if (index >= items)
      refuse(path, fmt::format("{}", index), fmt::format("must be the index of one of {} {}", items, list));
  }
  void kind(const std::string& path, const GeneratedKind& kind) {
    if (kind.shapes.empty()) refuse(member_path(path, "shapes"), "[]", "must name a shape");
    for (std::size_t k = 0; k < kind.shapes.size(); ++k) {
      const std::string of_shape = item_path(member_path(path, "shapes"), k);
      const std::size_t shape = kind.shapes[k];
      names(of_shape, shape, scene_.shapes.size(), "shapes");
      if (shape < scene_.shapes.size() && std::holds_alternative<PlaneSource>(scene_.shapes[shape].source))
        refuse(of_shape, fmt::format("{}", shape), "must not be a plane");
    }
    names(member_path(path, "material"), kind.material, scene_.materials.size(), "materials");
  }
  // How many bodies it makes; each factor is within kMaxSceneBodies, else it is refused.
  std::uint64_t grid(const std::string& path, const GridGenerator& grid) {
    kind(path, grid.kind);
    if (grid.in_tray) {
      count(member_path(path, "bodies"), grid.bodies, 0, kMaxSceneBodies);
      if (!scene_.tray) refuse(member_path(path, "in_tray"), "true", "must not be without a tray");
      return grid.bodies;
    }
    std::uint64_t made = 1;
    const auto times = [&](const std::string& of, std::uint64_t factor) {
      count(of, factor, 0, kMaxSceneBodies);
      made = wrong_.empty() ? made * factor : 0;
      count(member_path(path, "count") + ": bodies", made, 0, kMaxSceneBodies);
    };
    for (std::size_t k = 0; k < 3; ++k) times(item_path(member_path(path, "count"), k), grid.count[k]);
    for (std::size_t k = 0; k < 2 && grid.blocks; ++k)
      times(item_path(member_path(path, "blocks.count"), k), grid.blocks->count[k]);
    return made;
  }

  const Scene& scene_;
  std::string wrong_;
};

}  // namespace

Status check_scene_data(const Scene& scene) {
  SceneData data(scene);
  data.step();
  data.bodies();
  data.generators();
  return std::move(data).status();
}

}  // namespace poise::io
