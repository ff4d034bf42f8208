// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "poise/assets/tree_cache.h"
#include "poise/result.h"
#include "poise/scheduler/policy.h"
#include "poise/shape.h"
#include "poise/step.h"
#include "poise/types.h"
#include "poise/world.h"

namespace poise {

/// The most bodies that a scene may have, generated ones included.
inline constexpr std::uint64_t kMaxSceneBodies = 10'000'000;
/// The most frames that a run may have: the report of each stays in memory.
inline constexpr std::uint64_t kMaxSceneFrames = 1'000'000;

/// A named material of a scene file.
struct SceneMaterial {
  std::string name;
  Material material;
};

/// A ball.
struct SphereSource {
  double radius_m = 0;
};
/// A half-space, as make_plane_shape.
struct PlaneSource {
  Vec3 normal = Vec3::UnitZ();
  double offset_m = 0;
};
/// A mesh file with a sphere tree to be built for it.
struct MeshSource {
  std::filesystem::path file;        ///< as written; a relative one is relative to Scene::base
  double scale = 1;                  ///< metres per unit of the file
  Level depth = 3;                   ///< of the sphere tree
  double shell_thickness_m = 0;      ///< > 0: the surface alone, as plates of this thickness; 0: a solid
  Quat rotation = Quat::Identity();  ///< turns the file's frame into that of the shape, about the file's origin
  bool turned = false;               ///< the file gives a rotation: `up` or `rotation_wxyz`
};
/// A union of spheres, as make_spheres_shape.
struct SpheresSource {
  std::vector<Sphere> spheres;
};
/// A sphere tree from a file, with or without its mesh.
struct TreeSource {
  std::filesystem::path file;    ///< a `.sph` file, as MeshSource::file
  double scale = 1;              ///< of tree and mesh
  std::filesystem::path mesh;    ///< the mesh that the tree covers; empty: its leaves are the object
  bool allow_leaks = false;      ///< with a mesh: use the tree even if it does not cover the surface
  double shell_thickness_m = 0;  ///< with a mesh: as MeshSource::shell_thickness_m
};

/// A named shape as the file describes it: no mesh or tree is loaded yet.
struct SceneShape {
  std::string name;
  std::variant<SphereSource, PlaneSource, MeshSource, SpheresSource, TreeSource> source;
};

/// A body in the list of the file.
struct SceneBody {
  std::string name;           ///< may be empty
  std::size_t shape = 0;      ///< index into Scene::shapes
  std::size_t material = 0;   ///< index into Scene::materials
  BodyDefinition definition;  ///< its shape and material ids are unset
};

/// Fields that grids and streams share. Generated bodies have their *centre of mass* at the generated point.
struct GeneratedKind {
  std::vector<std::size_t> shapes;  ///< indices into Scene::shapes, at least one, no planes
  bool mix_by_seed = false;         ///< shapes drawn at random instead of in turn
  std::size_t material = 0;
  bool random_orientation = false;
  Vec3 velocity_mps = Vec3::Zero();
  double speed_mps = 0;   ///< in a random direction, added to the velocity
  double spin_radps = 0;  ///< about a random axis
  std::uint64_t seed = 1;
  std::uint32_t group = 1;
  std::uint32_t collides_with = 0xffffffffU;
  double importance = 1;
};

/// Places where a free grid is repeated: x fastest, then y.
struct GridBlocks {
  std::array<std::uint64_t, 2> count{1, 1};
  std::array<double, 2> spacing_m{0, 0};
};

/// A jittered grid: x fastest, then y, then z.
struct GridGenerator {
  GeneratedKind kind;
  bool is_static = false;                ///< its bodies never move
  std::array<std::uint64_t, 3> count{};  ///< free grid: along x, y, z; unused in the tray
  Vec3 origin_m = Vec3::Zero();          ///< free grid: point of the first body
  std::optional<GridBlocks> blocks;      ///< free grid: one grid after the other
  double spacing_m = 1;
  double jitter_m = 0;       ///< each coordinate moves by up to this, uniformly distributed
  bool in_tray = false;      ///< layers that fill the tray from below, as many as needed for `bodies`
  std::uint64_t bodies = 0;  ///< in the tray
  double bottom_m = 0;       ///< in the tray: smallest gap between the floor and the bounding spheres
};

/// A fixed number of bodies at equal intervals of time, at random points of a box.
struct StreamGenerator {
  GeneratedKind kind;
  std::uint64_t total = 0;
  double from_s = 0;
  double to_s = 0;  ///< body k of n comes before the first frame at or after from + k (to - from) / n
  Vec3 region_min_m = Vec3::Zero();
  Vec3 region_max_m = Vec3::Zero();
  std::optional<double> life_s;  ///< a body leaves before the first frame at or after its time to come plus this
};

using SceneGenerator = std::variant<GridGenerator, StreamGenerator>;

/// A floor z = 0 and four walls around the origin; all are static planes.
struct SceneTray {
  std::size_t material = 0;
  double side_m = 0;                ///< 0: from side_per_sqrt_body_m
  double side_per_sqrt_body_m = 0;  ///< side = this * sqrt(bodies that the generators make)
};

/// A place of a camera that moves.
struct CameraKey {
  double time_s = 0;  ///< of the run, after that of the key before
  Vec3 position_m = Vec3::Zero();
  Vec3 look_at_m = Vec3::UnitX();
  double vertical_fov_deg = 50;
};

/// The viewer's camera, world frame.
struct SceneCamera {
  Vec3 position_m = Vec3::Zero();  ///< with a path: of its first key, as are look_at_m and vertical_fov_deg
  Vec3 look_at_m = Vec3::UnitX();
  Vec3 up = Vec3::UnitZ();
  double vertical_fov_deg = 50;
  std::array<double, 2> resolution_px{1280, 720};
  std::vector<CameraKey> path;  ///< empty: the camera stands still; otherwise at least two keys
  bool loop = false;            ///< the path begins again after its last key, which is at the place of the first
};

/// Where a viewer looks at a time.
struct GazeKey {
  double time_s = 0;  ///< of the run, after that of the key before
  std::array<double, 2> at_px{};
};

/// A gaze that moves over the image.
struct SceneGaze {
  std::vector<GazeKey> path;   ///< at least one key, or empty until the file is read
  bool jumps = false;          ///< it stays at each key until the next; otherwise it moves straight from key to key
  bool loop = false;           ///< the path begins again after its last key
  std::filesystem::path file;  ///< a recorded gaze, as MeshSource::file; empty: the path is that of the scene
  std::string text;            ///< what was read from the file
};

/// The work that a host does in each frame after the step and before its deadline. It is simulated by busy waiting.
struct SceneHostWork {
  double load_ms = 0;                ///< time on the CPU, >= 0
  double jitter_ms = 0;              ///< each frame's load differs by up to this, at most load_ms
  std::optional<double> reserve_ms;  ///< reserved for it; empty: learned from earlier frames
};

/// The checked content of a scene file, as plain data (docs/scene-format.md).
struct Scene {
  std::string name;
  std::string description;     ///< may be empty
  std::string source;          ///< the file, for messages
  std::filesystem::path base;  ///< folder that its relative files are relative to
  Vec3 gravity_mps2 = Vec3::Zero();
  double dt_s = 0;
  std::uint64_t frames = 600;
  std::uint64_t seed = 1;
  std::optional<double> deadline_ms;
  std::optional<double> alpha;  ///< WorldSettings::alpha
  std::optional<SceneHostWork> host_work;
  Level max_level = kMaxTreeDepth;              ///< no pair is refined beyond this level of its trees
  bool polygons = false;                        ///< one more level, by the triangles of meshes: StepInput::polygons
  bool backtracking = false;                    ///< StepInput::backtracking
  bool sleeping = false;                        ///< WorldSettings::sleeping
  IslandsWait islands_wait = IslandsWait::Any;  ///< WorldSettings::islands_wait
  scheduler::Policy policy;
  std::optional<SceneCamera> camera;
  std::optional<std::array<double, 2>> gaze_px;  ///< from the top left corner; the centre of the image otherwise
  std::optional<SceneGaze> gaze;                 ///< instead of gaze_px
  std::vector<SceneMaterial> materials;          ///< in file order, as are the lists below
  std::vector<SceneShape> shapes;
  std::vector<SceneBody> bodies;
  std::optional<SceneTray> tray;
  std::vector<SceneGenerator> generators;
};

/// Reads and checks a scene file. The files that it names are not opened here but in SceneRun::create. Any thread.
/// Refused with file, field, value and rule; syntax errors with line and column.
Result<Scene> read_scene(const std::filesystem::path& file);

/// The same from text. Messages begin with `name`; relative files are relative to `base`. The returned error is the
/// first one found; `errors`, if given, receives all, one line each, in reading order (the first 10,000, then their
/// number).
Result<Scene> parse_scene(std::string_view text, const std::string& name, const std::filesystem::path& base,
                          std::vector<std::string>* errors = nullptr);

/// A recorded gaze (docs/scene-format.md) from its text, for an image of this size; `name` begins each message. Refused
/// with line, field, value and rule. Any thread.
Result<std::vector<GazeKey>> parse_gaze(std::string_view text, const std::string& name,
                                        const std::array<double, 2>& resolution_px);

/// Reads the file of a scene's gaze, if it has one that was not read yet; SceneRun::create does so by itself. Refused
/// as parse_gaze, and a file that cannot be read.
Status read_gaze(Scene& scene);

/// Number of bodies that the generators of a scene make by its own counts.
std::uint64_t generated_body_count(const Scene& scene);

/// The camera and gaze of a scene at a time of its run, seconds. View::present is false for a scene without a camera.
/// Between the keys of a path, position and look_at follow cubic Hermite curves with the tangents of Catmull and Rom
/// (1974) for unequal times, zero at the ends unless it is a loop; the field of view changes linearly. Where such a
/// line of sight would have no direction, it has that of the key before.
View scene_view(const Scene& scene, double time_s = 0);

/// Settings of a run that the scene file does not hold.
struct SceneRunOptions {
  WorldSettings world;  ///< gravity and seed are taken from the scene, which may also turn sleeping on and let fewer
                        ///< islands wait; the rest is used as given
  /// Number of bodies that all generators make together, in proportion to their own counts; empty: those of the scene.
  std::optional<std::uint64_t> bodies;
  std::optional<std::uint64_t> seed;  ///< replaces the scene's seed; also moves generated bodies
  /// Memory that the run may take, in bytes, as far as it can be told before: bodies that need more by the estimates of
  /// docs/scene-format.md ("What a scene needs") are refused before one of them is made, and what they leave bounds
  /// WorldSettings::max_pairs. Meshes and trees are not counted. Empty: no limit.
  std::optional<std::uint64_t> max_memory_bytes = {};
  /// Where built trees are cached; empty: no file but the scene's is read or written.
  std::optional<TreeCacheSettings> tree_cache;
  /// Called from time to time while trees are built, on the calling thread, with the completed share of all shapes, in
  /// [0, 1]. May be empty.
  std::function<void(double share)> tree_progress = {};
  /// Ends the loading of shapes when it is stopped: create() is then refused as Cancelled. Trees that were finished
  /// before are in the cache.
  std::stop_token stop = {};
};

/// Number of trees by the way they were obtained (TreeCacheOutcome).
struct TreeCacheUse {
  std::size_t off = 0, hits = 0, built = 0, rebuilt = 0, not_writable = 0;
  std::size_t evicted = 0;  ///< other entries that were removed to respect the limit
};

/// One body of a running scene.
struct RunBody {
  BodyId id;
  std::uint64_t number = 0;  ///< from 0 in scene order; that of a body that has left is not given again
  std::size_t shape = 0;     ///< index into SceneRun::shapes()
  std::size_t material = 0;  ///< index into Scene::materials
  MotionType motion = MotionType::Dynamic;
};

/// Owns the World of a scene, and adds and removes the bodies of its streams when they are due. Invariant: bodies() is
/// what is in the World, in scene order: the list of the file, the tray (floor, walls at -x, +x, -y, +y), the grids in
/// order, then stream bodies and poured ones in order of arrival.
///
/// One thread at a time. Two runs with the same scene and options have the same bodies, bit for bit, on any machine.
class SceneRun {
 public:
  /// Loads meshes and trees, builds sphere trees, and adds the bodies of the first frame. Refused as read_scene.
  static Result<SceneRun> create(const Scene& scene, const SceneRunOptions& options);
  SceneRun(SceneRun&&) noexcept;
  SceneRun& operator=(SceneRun&&) noexcept;
  ~SceneRun();

  /// Removes the stream bodies whose life has ended at the start of frame `frame` (time frame * dt), adds those that
  /// are due, and sets the view. Call before each step; each frame is after the one before.
  Status before_frame(std::uint64_t frame);

  /// Adds up to `count` bodies more, for hosts whose user asks for them: of the kinds of the scene's generators but
  /// static grids, in proportion to their counts, or without any as the dynamic bodies of its list. With gravity they
  /// are dropped above where such bodies begin, else they come at free places there. They have no life. Returns how
  /// many found room; the others may be asked for again after a step. Takes time linear in the bodies. Refused: a scene
  /// without dynamic bodies.
  Result<std::uint64_t> pour(std::uint64_t count);
  /// Removes up to `count` dynamic bodies, those that came last first. Returns how many there were.
  Result<std::uint64_t> remove_last(std::uint64_t count);
  /// The scene from its start, with the shapes that were loaded for this run. Refused as create().
  [[nodiscard]] Result<SceneRun> again(const SceneRunOptions& options) const;

  [[nodiscard]] World& world();
  [[nodiscard]] const World& world() const;
  [[nodiscard]] std::span<const RunBody> bodies() const;
  /// Uncertain properties of loaded shapes, one line each with scene file and field, in the order of the shapes.
  [[nodiscard]] std::vector<std::string> warnings() const;
  [[nodiscard]] const TreeCacheUse& tree_cache_use() const;
  /// In the order of Scene::shapes; with a tray, its five planes follow.
  [[nodiscard]] std::span<const ShapePtr> shapes() const;
  /// The camera at the start of the frame of the last before_frame, or of frame 0.
  [[nodiscard]] const View& view() const;
  /// Number of bodies when every stream has ended and all bodies with a life have left, static ones and planes
  /// included.
  [[nodiscard]] std::uint64_t final_body_count() const;
  /// Side of the tray, metres; 0 without a tray.
  [[nodiscard]] double tray_side_m() const;

 private:
  struct Impl;
  explicit SceneRun(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace poise
