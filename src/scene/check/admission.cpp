// SPDX-License-Identifier: MIT
#include "scene/check/admission.h"

#include <algorithm>
#include <utility>

#include "assets/json/json_document.h"
#include "poise/world.h"

namespace poise::io {
namespace {

/// A World that bodies are offered one after another; none stays. Invariant: it has the shapes and materials of the
/// scene, in their order, as far as there is no error.
class Door {
 public:
  Door(const Scene& scene, World& world) : scene_(scene), world_(world) {}

  void add(std::span<const CheckedShape> shapes) {
    for (const CheckedShape& shape : shapes) shapes_.push_back(world_.add_shape(shape.shape));
    for (const SceneMaterial& material : scene_.materials) {
      const Result<MaterialId> made = world_.add_material(material.material);
      if (made) {
        materials_.push_back(made.value());
      } else {
        refuse(member_path("materials", material.name), made.error());
      }
    }
  }
  /// False if it was refused.
  bool offer(BodyDefinition definition, std::size_t shape, std::size_t material, const std::string& place) {
    definition.shape = shapes_[shape];
    definition.material = materials_[material];
    const Result<BodyId> made = world_.add_body(definition);
    if (!made) {
      refuse(place, made.error());
      return false;
    }
    (void)world_.remove_body(made.value());
    return true;
  }
  [[nodiscard]] bool sound() const { return refused_.empty(); }
  std::vector<std::string> refused() && { return std::move(refused_); }

 private:
  void refuse(const std::string& place, const Error& error) {
    refused_.push_back(scene_.source + ": " + place + ": " + error.message);
  }

  const Scene& scene_;
  World& world_;
  std::vector<ShapeId> shapes_;
  std::vector<MaterialId> materials_;
  std::vector<std::string> refused_;
};

}  // namespace

std::vector<std::string> refused_by_world(const Scene& scene, std::span<const CheckedShape> shapes,
                                          std::span<const GeneratedBody> generated, std::size_t most_generated) {
  WorldSettings settings;
  settings.threads = 1;
  settings.gravity_mps2 = scene.gravity_mps2;
  Result<World> world = World::create(settings);
  if (!world) return {scene.source + ": " + world.error().message};
  Door door(scene, world.value());
  door.add(shapes);
  if (!door.sound()) return std::move(door).refused();
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    door.offer(body.definition, body.shape, body.material, item_path("bodies", i));
  }
  for (const GeneratedBody& body : generated.first(std::min(most_generated, generated.size()))) {
    const Shape& shape = *shapes[body.shape].shape;
    if (!door.offer(definition_of(body, shape), body.shape, body.kind->material, "generators")) break;
  }
  return std::move(door).refused();
}

}  // namespace poise::io
