// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/generators.h"
#include "scene/json_document.h"
#include "scene/scene_shapes.h"

namespace poise {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

struct SceneRun::Impl {
  Scene scene;
  World world;
  View view;
  std::vector<ShapePtr> shapes = {};
  std::vector<ShapeId> shape_ids = {};
  std::vector<MaterialId> material_ids = {};
  std::vector<RunBody> bodies = {};
  std::uint64_t next_number = 0;                  ///< of the next body that is added
  std::vector<io::GeneratedBody> generated = {};  ///< refers to scene
  std::size_t next_streamed = 0;                  ///< index into generated
  std::uint64_t first_generated = 0;              ///< number of the body of generated[0]
  double next_leave_s = kNever;                   ///< of the bodies that are there
  double tray_side_m = 0;
  TreeCacheUse tree_cache_use = {};

  Status add(const BodyDefinition& definition, std::size_t shape, std::size_t material, const std::string& place);
  Status add_generated(const io::GeneratedBody& body);
  Status add_shapes_and_materials(const io::LoadSettings& settings);
  Status add_tray();
  Status add_start(const SceneRunOptions& options, std::uint64_t seed);
  [[nodiscard]] double leaves_s(const RunBody& body) const;
  Status remove_due(double now_s);
};

Status SceneRun::Impl::add(const BodyDefinition& definition, std::size_t shape, std::size_t material,
                           const std::string& place) {
  BodyDefinition whole = definition;
  whole.shape = shape_ids[shape];
  whole.material = material_ids[material];
  const Result<BodyId> made = world.add_body(whole);
  if (!made) return Error{made.error().kind, scene.source + ": " + place + ": " + made.error().message};
  bodies.push_back({made.value(), next_number++, shape, material, whole.motion});
  return Done{};
}

Status SceneRun::Impl::add_generated(const io::GeneratedBody& body) {
  BodyDefinition definition;
  // The World takes the position of the shape's origin; generators give the centre of mass.
  definition.position_m = body.center_m - body.orientation * shapes[body.shape]->origin_offset_m;
  definition.orientation = body.orientation;
  if (body.is_static) definition.motion = MotionType::Static;
  definition.velocity_mps = body.velocity_mps;
  definition.angular_velocity_radps = body.angular_velocity_radps;
  definition.group = body.kind->group;
  definition.collides_with = body.kind->collides_with;
  definition.importance = body.kind->importance;
  next_leave_s = std::min(next_leave_s, body.leaves_s);
  return add(definition, body.shape, body.kind->material, "generators");
}

double SceneRun::Impl::leaves_s(const RunBody& body) const {
  return body.number < first_generated ? kNever : generated[body.number - first_generated].leaves_s;
}

Status SceneRun::Impl::remove_due(double now_s) {
  if (now_s < next_leave_s) return Done{};
  next_leave_s = kNever;
  for (const RunBody& body : bodies) {
    const double when_s = leaves_s(body);
    if (when_s > now_s) {
      next_leave_s = std::min(next_leave_s, when_s);
      continue;
    }
    const Status removed = world.remove_body(body.id);
    if (!removed) return removed;
  }
  std::erase_if(bodies, [this, now_s](const RunBody& body) { return leaves_s(body) <= now_s; });
  return Done{};
}

Status SceneRun::Impl::add_shapes_and_materials(const io::LoadSettings& settings) {
  Result<io::LoadedShapes> loaded = io::load_shapes(scene, settings);
  if (!loaded) return loaded.error();
  tree_cache_use = loaded.value().tree_cache_use;
  shapes = std::move(loaded.value().shapes);
  for (const ShapePtr& shape : shapes) shape_ids.push_back(world.add_shape(shape));
  for (const SceneMaterial& material : scene.materials) {
    const Result<MaterialId> made = world.add_material(material.material);
    if (!made) {
      const std::string path = io::member_path("materials", material.name);
      return Error{made.error().kind, scene.source + ": " + path + ": " + made.error().message};
    }
    material_ids.push_back(made.value());
  }
  return Done{};
}

Status SceneRun::Impl::add_tray() {
  const double half_m = 0.5 * tray_side_m;
  const std::pair<Vec3, double> planes[] = {{Vec3::UnitZ(), 0},
                                            {Vec3::UnitX(), -half_m},
                                            {-Vec3::UnitX(), -half_m},
                                            {Vec3::UnitY(), -half_m},
                                            {-Vec3::UnitY(), -half_m}};
  for (const auto& [normal, offset_m] : planes) {
    const Result<ShapePtr> shape = make_plane_shape(normal, offset_m);
    if (!shape) return shape.error();
    shapes.push_back(shape.value());
    shape_ids.push_back(world.add_shape(shape.value()));
    BodyDefinition definition;
    definition.motion = MotionType::Static;
    const Status added = add(definition, shapes.size() - 1, scene.tray->material, "tray");
    if (!added) return added;
  }
  return Done{};
}

Status SceneRun::Impl::add_start(const SceneRunOptions& options, std::uint64_t seed) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    const Status added = add(body.definition, body.shape, body.material, io::item_path("bodies", i));
    if (!added) return added;
  }
  io::ExpandOptions expand;
  expand.bodies = options.bodies;
  expand.seed = seed;
  std::vector<double> radius_m;
  for (const ShapePtr& shape : shapes) radius_m.push_back(shape->bounding_radius_m);
  expand.radius_m = radius_m;
  tray_side_m = io::tray_side_m(scene, options.bodies.value_or(generated_body_count(scene)), radius_m);
  expand.tray_side_m = tray_side_m;
  Result<std::vector<io::GeneratedBody>> made = io::expand_generators(scene, expand);
  if (!made) return made.error();
  generated = std::move(made).value();
  if (scene.tray) {
    const Status added = add_tray();
    if (!added) return added;
  }
  first_generated = next_number;
  for (; next_streamed < generated.size() && !generated[next_streamed].streamed; ++next_streamed) {
    const Status added = add_generated(generated[next_streamed]);
    if (!added) return added;
  }
  return Done{};
}

SceneRun::SceneRun(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SceneRun::SceneRun(SceneRun&&) noexcept = default;
SceneRun& SceneRun::operator=(SceneRun&&) noexcept = default;
SceneRun::~SceneRun() = default;

Result<SceneRun> SceneRun::create(const Scene& scene, const SceneRunOptions& options) {
  if (options.bodies && scene.generators.empty()) {
    return bad_input(scene.source + ": has no generators, so the number of bodies cannot be chosen");
  }
  if (options.bodies && (*options.bodies == 0 || *options.bodies > kMaxSceneBodies)) {
    return bad_input(fmt::format("{} bodies, must be 1 to {}", *options.bodies, kMaxSceneBodies));
  }
  WorldSettings settings = options.world;
  settings.gravity_mps2 = scene.gravity_mps2;
  settings.seed = options.seed.value_or(scene.seed);
  settings.sleeping = settings.sleeping || scene.sleeping;
  settings.islands_wait = std::min(settings.islands_wait, scene.islands_wait);
  Result<World> world = World::create(settings);
  if (!world) return world.error();
  auto impl =
      std::make_unique<Impl>(Impl{.scene = scene, .world = std::move(world).value(), .view = scene_view(scene)});
  const Status loaded = impl->add_shapes_and_materials({settings.threads, options.tree_cache, options.tree_progress});
  if (!loaded) return loaded.error();
  const Status started = impl->add_start(options, settings.seed);
  if (!started) return started.error();
  return SceneRun(std::move(impl));
}

Status SceneRun::before_frame(std::uint64_t frame) {
  const double now_s = static_cast<double>(frame) * impl_->scene.dt_s;
  // First those that leave, so that a body with a short life is there for a frame.
  const Status removed = impl_->remove_due(now_s);
  if (!removed) return removed;
  if (impl_->scene.camera && !impl_->scene.camera->path.empty()) impl_->view = scene_view(impl_->scene, now_s);
  std::size_t& next = impl_->next_streamed;
  while (next < impl_->generated.size() && impl_->generated[next].due_s <= now_s) {
    const Status added = impl_->add_generated(impl_->generated[next]);
    if (!added) return added;
    ++next;
  }
  return Done{};
}

World& SceneRun::world() { return impl_->world; }
const World& SceneRun::world() const { return impl_->world; }
std::span<const RunBody> SceneRun::bodies() const { return impl_->bodies; }
std::vector<std::string> SceneRun::warnings() const { return io::shape_warnings(impl_->scene, impl_->shapes); }
const TreeCacheUse& SceneRun::tree_cache_use() const { return impl_->tree_cache_use; }
std::span<const ShapePtr> SceneRun::shapes() const { return impl_->shapes; }
const View& SceneRun::view() const { return impl_->view; }
double SceneRun::tray_side_m() const { return impl_->tray_side_m; }
std::uint64_t SceneRun::final_body_count() const {
  std::uint64_t count = impl_->first_generated;
  for (const io::GeneratedBody& body : impl_->generated) count += body.leaves_s < kNever ? 0 : 1;
  return count;
}

}  // namespace poise
