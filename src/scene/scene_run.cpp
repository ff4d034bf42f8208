// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "assets/json/json_document.h"
#include "poise/scene/scene.h"
#include "scene/generators.h"
#include "scene/pouring.h"
#include "scene/scene_data.h"
#include "scene/scene_memory.h"
#include "scene/scene_shapes.h"

namespace poise {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
/// No body has this number.
constexpr std::uint64_t kRemoved = std::numeric_limits<std::uint64_t>::max();

}  // namespace

struct SceneRun::Impl {
  Scene scene;
  World world;
  View view;
  std::vector<ShapePtr> shapes = {};
  std::vector<ShapeId> shape_ids = {};
  std::vector<MaterialId> material_ids = {};
  std::vector<RunBody> bodies = {};
  std::uint64_t next_number = 0;                       ///< of the next body that is added
  std::optional<std::uint64_t> generated_bodies = {};  ///< how many were asked for
  std::vector<io::GeneratedBody> streamed = {};        ///< bodies that come later, by due time; refers to scene
  std::size_t next_streamed = 0;                       ///< index into streamed
  std::uint64_t first_generated = 0;                   ///< number of the first body that may leave
  std::vector<double> leave_s = {};                    ///< of the bodies from first_generated on, by number
  double next_leave_s = kNever;                        ///< of the bodies that are there
  double tray_side_m = 0;
  TreeCacheUse tree_cache_use = {};
  std::uint64_t seed = 1;
  std::optional<io::Pouring> pouring = {};  ///< made when it is first asked for

  static Result<std::unique_ptr<Impl>> begin(const Scene& scene, const SceneRunOptions& options);
  Status add(const BodyDefinition& definition, std::size_t shape, std::size_t material, const std::string& place);
  Status add_generated(const io::GeneratedBody& body);
  Status load_shapes(const io::LoadSettings& settings);
  Status add_shapes_and_materials();
  Status add_tray();
  /// Of the shapes of the scene.
  [[nodiscard]] std::vector<double> radius_m() const;
  /// All bodies of the generators; refers to scene.
  [[nodiscard]] Result<std::vector<io::GeneratedBody>> generate() const;
  Status add_start(const SceneRunOptions& options);
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
  next_leave_s = std::min(next_leave_s, body.leaves_s);
  leave_s.push_back(body.leaves_s);
  return add(io::definition_of(body, *shapes[body.shape]), body.shape, body.kind->material, "generators");
}

double SceneRun::Impl::leaves_s(const RunBody& body) const {
  return body.number < first_generated ? kNever : leave_s[body.number - first_generated];
}

Status SceneRun::Impl::remove_due(double now_s) {
  if (now_s < next_leave_s) return Done{};
  double next_s = kNever;
  for (const RunBody& body : bodies) {
    const double when_s = leaves_s(body);
    if (when_s > now_s) {
      next_s = std::min(next_s, when_s);
      continue;
    }
    // The caller may have removed it before its time.
    if (!world.contains(body.id)) continue;
    const Status removed = world.remove_body(body.id);
    if (!removed) return removed;
  }
  std::erase_if(bodies, [this, now_s](const RunBody& body) { return leaves_s(body) <= now_s; });
  next_leave_s = next_s;
  return Done{};
}

Status SceneRun::Impl::load_shapes(const io::LoadSettings& settings) {
  Result<io::LoadedShapes> loaded = io::load_shapes(scene, settings);
  if (!loaded) return loaded.error();
  tree_cache_use = loaded.value().tree_cache_use;
  shapes = std::move(loaded.value().shapes);
  return Done{};
}

Status SceneRun::Impl::add_shapes_and_materials() {
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
    if (!shape) {
      return Error{shape.error().kind,
                   fmt::format("{}: tray: a side of {:g} m: {}", scene.source, tray_side_m, shape.error().message)};
    }
    shapes.push_back(shape.value());
    shape_ids.push_back(world.add_shape(shape.value()));
    BodyDefinition definition;
    definition.motion = MotionType::Static;
    const Status added = add(definition, shapes.size() - 1, scene.tray->material, "tray");
    if (!added) return added;
  }
  return Done{};
}

std::vector<double> SceneRun::Impl::radius_m() const {
  std::vector<double> radius_m;
  for (const ShapePtr& shape : std::span(shapes).first(scene.shapes.size()))
    radius_m.push_back(shape->bounding_radius_m);
  return radius_m;
}

Result<std::vector<io::GeneratedBody>> SceneRun::Impl::generate() const {
  const std::vector<double> radius_m = this->radius_m();
  io::ExpandOptions expand;
  expand.bodies = generated_bodies;
  expand.seed = seed;
  expand.radius_m = radius_m;
  expand.tray_side_m = tray_side_m;
  return io::expand_generators(scene, expand);
}

Status SceneRun::Impl::add_start(const SceneRunOptions& options) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    const Status added = add(body.definition, body.shape, body.material, io::item_path("bodies", i));
    if (!added) return added;
  }
  generated_bodies = options.bodies;
  tray_side_m = io::tray_side_m(scene, options.bodies.value_or(generated_body_count(scene)), radius_m());
  const Result<std::vector<io::GeneratedBody>> made = generate();
  if (!made) return made.error();
  const std::vector<io::GeneratedBody>& generated = made.value();
  if (scene.tray) {
    const Status added = add_tray();
    if (!added) return added;
  }
  first_generated = next_number;
  auto next = generated.begin();
  for (; next != generated.end() && !next->streamed; ++next) {
    const Status added = add_generated(*next);
    if (!added) return added;
  }
  // Those of the start are not kept: nobody but pour() asks for them again, and they take 144 bytes each.
  streamed.assign(next, generated.end());
  return Done{};
}

SceneRun::SceneRun(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SceneRun::SceneRun(SceneRun&&) noexcept = default;
SceneRun& SceneRun::operator=(SceneRun&&) noexcept = default;
SceneRun::~SceneRun() = default;

Result<std::unique_ptr<SceneRun::Impl>> SceneRun::Impl::begin(const Scene& scene, const SceneRunOptions& options) {
  const Status sound = io::check_scene_data(scene);
  if (!sound) return sound.error();
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
  if (options.max_memory_bytes) {
    const Result<std::uint32_t> pairs =
        io::pairs_that_fit(scene, options.bodies, settings.threads, *options.max_memory_bytes, settings.max_pairs);
    if (!pairs) return pairs.error();
    settings.max_pairs = pairs.value();
  }
  Result<World> world = World::create(settings);
  if (!world) return world.error();
  auto impl = std::make_unique<Impl>(Impl{.scene = scene, .world = std::move(world).value(), .view = View{}});
  impl->seed = settings.seed;
  const Status gaze = read_gaze(impl->scene);
  if (!gaze) return gaze.error();
  impl->view = scene_view(impl->scene);
  return impl;
}

Result<SceneRun> SceneRun::create(const Scene& scene, const SceneRunOptions& options) {
  Result<std::unique_ptr<Impl>> begun = Impl::begin(scene, options);
  if (!begun) return begun.error();
  std::unique_ptr<Impl> impl = std::move(begun).value();
  Status done = impl->load_shapes({options.world.threads, options.tree_cache, options.tree_progress, options.stop});
  if (done) done = impl->add_shapes_and_materials();
  if (done) done = impl->add_start(options);
  if (!done) return done.error();
  return SceneRun(std::move(impl));
}

Result<SceneRun> SceneRun::again(const SceneRunOptions& options) const {
  Result<std::unique_ptr<Impl>> begun = Impl::begin(impl_->scene, options);
  if (!begun) return begun.error();
  std::unique_ptr<Impl> impl = std::move(begun).value();
  // Those of the tray, which come after them, depend on the number of bodies.
  const auto shapes = std::span(impl_->shapes).first(impl_->scene.shapes.size());
  impl->shapes.assign(shapes.begin(), shapes.end());
  impl->tree_cache_use = impl_->tree_cache_use;
  Status done = impl->add_shapes_and_materials();
  if (done) done = impl->add_start(options);
  if (!done) return done.error();
  return SceneRun(std::move(impl));
}

Result<std::uint64_t> SceneRun::pour(std::uint64_t count) {
  if (!impl_->pouring) {
    const Result<std::vector<io::GeneratedBody>> generated = impl_->generate();
    if (!generated) return generated.error();
    impl_->pouring.emplace(impl_->scene, generated.value(), impl_->radius_m(), impl_->tray_side_m, impl_->seed);
  }
  if (!impl_->pouring->any())
    return bad_input(impl_->scene.source + ": has no dynamic bodies, so there is nothing to pour");
  const Result<std::vector<io::GeneratedBody>> bodies = impl_->pouring->next(impl_->world, count);
  if (!bodies) return bodies.error();
  for (const io::GeneratedBody& body : bodies.value()) {
    const Status added = impl_->add_generated(body);
    if (!added) return added.error();
  }
  return std::uint64_t{bodies.value().size()};
}

Result<std::uint64_t> SceneRun::remove_last(std::uint64_t count) {
  std::uint64_t removed = 0;
  std::vector<RunBody>& bodies = impl_->bodies;
  for (std::size_t i = bodies.size(); i-- > 0 && removed < count;) {
    if (bodies[i].motion != MotionType::Dynamic) continue;
    const Status done = impl_->world.remove_body(bodies[i].id);
    if (!done) return done.error();
    bodies[i].number = kRemoved;
    ++removed;
  }
  std::erase_if(bodies, [](const RunBody& body) { return body.number == kRemoved; });
  return removed;
}

Status SceneRun::before_frame(std::uint64_t frame) {
  const double now_s = static_cast<double>(frame) * impl_->scene.dt_s;
  if (impl_->scene.camera && (!impl_->scene.camera->path.empty() || impl_->scene.gaze))
    impl_->view = scene_view(impl_->scene, now_s);
  // To change bodies would end the step.
  if (impl_->world.step_unfinished()) return Done{};
  // First those that leave, so that a body with a short life is there for a frame.
  const Status removed = impl_->remove_due(now_s);
  if (!removed) return removed;
  std::size_t& next = impl_->next_streamed;
  while (next < impl_->streamed.size() && impl_->streamed[next].due_s <= now_s) {
    const Status added = impl_->add_generated(impl_->streamed[next]);
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
  std::uint64_t count = 0;
  for (const RunBody& body : impl_->bodies) count += impl_->leaves_s(body) < kNever ? 0U : 1U;
  for (std::size_t i = impl_->next_streamed; i < impl_->streamed.size(); ++i)
    count += impl_->streamed[i].leaves_s < kNever ? 0U : 1U;
  return count;
}

}  // namespace poise
