// SPDX-License-Identifier: MIT
#include "studies/study_strips.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/files/scene_files.h"
#include "app/options/option_values.h"
#include "app/options/suggestions.h"
#include "app/picture/picture.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "capture/observe.h"
#include "collision/triangles/true_surface.h"
#include "scene/result_file.h"
#include "world/contact_model_names.h"

namespace poise::app {
namespace {

// Two jacks that come point to point, each with three arms ahead, turned so that the arms of one pass between those of
// the other: coarse balls meet long before the surfaces. Steps are so short that their length is no part of the gap.
constexpr const char* kTwoJacks = R"({
  "name": "two jacks", "dt_s": 0.001, "frames": 1150, "gravity_mps2": [0, 0, 0],
  "camera": {"position_m": [0, -6.4, 1.2], "look_at_m": [0, 0, 0], "vertical_fov_deg": 22, "resolution_px": [320, 190]},
  "materials": {"hard": {"restitution": 0.8, "friction": 0, "density_kgpm3": 1000}},
  "shapes": {"jack": {"mesh": {"file": "meshes/jack.obj", "depth": 2}}},
  "bodies": [
    {"name": "left", "shape": "jack", "material": "hard", "position_m": [-1.3, 0, -0.05], "velocity_mps": [2, 0, 0],
     "orientation_wxyz": [0.8880738, 0, 0.3250575, -0.3250575]},
    {"name": "right", "shape": "jack", "material": "hard", "position_m": [1.3, 0, 0.05], "velocity_mps": [-2, 0, 0],
     "orientation_wxyz": [0.8880738, 0, 0.3250575, -0.3250575]}
  ]
})";

constexpr std::size_t kMoments = 4;
/// The third moment is so far from the collision to the end.
constexpr double kLater = 0.4;

Result<Scene> scene_of(const StudyStripsOptions& o) {
  const Result<std::filesystem::path> file = find_scene(o.common.scene.empty() ? "two-body" : o.common.scene);
  if (!file) return file.error();
  return o.common.scene.empty() ? parse_scene(kTwoJacks, "two jacks", file.value().parent_path())
                                : read_scene(file.value());
}

/// A run as far as its collision, and from there to its end.
class Collision {
 public:
  Collision(const Scene& scene, SceneRun& run, const std::array<std::uint64_t, 2>& bodies)
      : scene_(scene), run_(run), bodies_(bodies) {}

  Status go(Strip& strip) {
    Status status = draw(0, strip);
    for (std::uint64_t frame = 0; status && frame < scene_.frames; ++frame) {
      status = run_.before_frame(frame);
      if (!status) return status;
      const Result<io::DrawnFrame> before = strip.met ? strip.moments.back() : drawn(frame);
      if (!before) return before.error();
      const std::array<collision::Pose, 2> poses = poses_now();
      StepInput input;
      input.dt_s = scene_.dt_s;
      input.polygons = strip.level == kPolygonBin;
      input.max_level = input.polygons ? kMaxTreeDepth : strip.level;
      if (run_.world().step(input).status != StepStatus::Done)
        return bad_input("the step was refused: its input is out of range");
      if (!strip.met && exchanged_impulse()) {
        strip.met = true;
        strip.time_s = static_cast<double>(frame) * scene_.dt_s;
        strip.gap_m = surface_gap_m(poses);
        strip.moments.push_back(before.value());
        later_ = frame + 1 + static_cast<std::uint64_t>(kLater * static_cast<double>(scene_.frames - frame - 1));
      }
      if (strip.met && strip.moments.size() == 2 && frame + 1 >= later_) status = draw(frame + 1, strip);
    }
    // Where nothing met, or too late, the end stands for what is missing.
    while (status && strip.moments.size() < kMoments) status = draw(scene_.frames, strip);
    for (std::size_t i = 0; i < 2; ++i) {
      const BodyState end = state(i);
      strip.velocity_mps[i] = end.velocity_mps;
      strip.spin_radps[i] = end.angular_velocity_radps;
    }
    return status;
  }

 private:
  [[nodiscard]] BodyState state(std::size_t which) const {
    return run_.world().state(run_.bodies()[bodies_[which]].id).value();
  }
  [[nodiscard]] Result<io::DrawnFrame> drawn(std::uint64_t frame) {
    return io::drawn_frame(scene_, run_, frame, static_cast<double>(frame) * scene_.dt_s);
  }
  Status draw(std::uint64_t frame, Strip& strip) {
    Result<io::DrawnFrame> seen = drawn(frame);
    if (!seen) return seen.error();
    strip.moments.push_back(std::move(seen).value());
    return Done{};
  }
  // The two with each other: what lies on a floor gets impulses long before.
  [[nodiscard]] bool exchanged_impulse() const {
    const std::array<BodyId, 2> two = {run_.bodies()[bodies_[0]].id, run_.bodies()[bodies_[1]].id};
    return std::ranges::any_of(run_.world().contacts(), [&](const Contact& contact) {
      const bool met = (contact.a == two[0] && contact.b == two[1]) || (contact.a == two[1] && contact.b == two[0]);
      return met && contact.impulse_ns.norm() > 0;
    });
  }
  [[nodiscard]] std::array<collision::Pose, 2> poses_now() const {
    std::array<collision::Pose, 2> poses;
    for (std::size_t i = 0; i < 2; ++i) poses[i] = {state(i).position_m, state(i).orientation.toRotationMatrix()};
    return poses;
  }
  [[nodiscard]] double surface_gap_m(const std::array<collision::Pose, 2>& poses) const {
    const auto surface = [this](std::size_t which) {
      return collision::true_surface_of(*run_.shapes()[run_.bodies()[bodies_[which]].shape]);
    };
    return collision::surface_distance_m(surface(0), poses[0], surface(1), poses[1]);
  }

  const Scene& scene_;
  SceneRun& run_;
  std::array<std::uint64_t, 2> bodies_;
  std::uint64_t later_ = 0;
};

std::vector<Level> levels_of(const SceneRun& run, const std::array<std::uint64_t, 2>& bodies) {
  Level deepest = 0;
  bool polygons = false;
  for (const std::uint64_t body : bodies) {
    const Shape& shape = *run.shapes()[run.bodies()[body].shape];
    deepest = std::max(deepest, shape.tree.depth());
    polygons = polygons || shape.surface;
  }
  std::vector<Level> levels;
  for (int level = 0; level <= deepest; ++level) levels.push_back(static_cast<Level>(level));
  if (polygons) levels.push_back(kPolygonBin);
  return levels;
}

Result<std::array<std::uint64_t, 2>> two_bodies_of(const SceneRun& run) {
  std::vector<std::uint64_t> moving;
  for (std::uint64_t i = 0; i < run.bodies().size(); ++i) {
    if (run.bodies()[i].motion == MotionType::Dynamic) moving.push_back(i);
  }
  if (moving.size() != 2)
    return bad_input(fmt::format("--scene: it has {} dynamic bodies, must have two that meet", moving.size()));
  return std::array{moving[0], moving[1]};
}

}  // namespace

Result<Strips> collide(const Scene& scene, const SceneRunOptions& start) {
  Strips all;
  all.scene = scene.name;
  std::vector<Level> levels(1);  // known once the first run is made
  for (std::size_t i = 0; i < levels.size(); ++i) {
    Result<SceneRun> run = SceneRun::create(scene, start);
    if (!run) return run.error();
    if (i == 0) {
      const Result<std::array<std::uint64_t, 2>> two = two_bodies_of(run.value());
      if (!two) return two.error();
      all.bodies = two.value();
      all.shapes = capture::captured_shapes(scene, run.value());
      levels = levels_of(run.value(), all.bodies);
    }
    Strip& strip = all.strips.emplace_back();
    strip.level = levels[i];
    double radii_m = 0;
    for (const std::uint64_t body : all.bodies) {
      const Shape& shape = *run.value().shapes()[run.value().bodies()[body].shape];
      radii_m += shape.bounding_radius_m;
      if (strip.level != kPolygonBin)
        strip.balls += shape.tree.nodes_at(std::min(strip.level, shape.tree.depth())).size();
    }
    const Status gone = Collision(scene, run.value(), all.bodies).go(strip);
    if (!gone) return gone.error();
    strip.gap_radii = strip.gap_m / (0.5 * radii_m);
  }
  return all;
}

io::StudyTable strips_table(const Strips& strips, const StudyStripsOptions& o) {
  io::StudyTable table = begin_study("strips", "poise study strips");
  table.facts = {{"scene", strips.scene}, {"contact", o.contact}};
  table.columns = {{"level", "level", 0},    {"balls", "balls", 0},          {"time_s", "collision, s", 3},
                   {"gap_mm", "gap, mm", 1}, {"gap_radii", "gap, radii", 3}, {"late_ms", "late, ms", 0}};
  for (const std::string body : {"left", "right"}) {
    for (const char axis : {'x', 'y', 'z'})
      table.columns.push_back({fmt::format("{}_v{}_mps", body, axis), fmt::format("{} v{}, m/s", body, axis), 3});
    table.columns.push_back({body + "_spin_radps", body + " spin, rad/s", 3});
  }
  table.columns.push_back({"error_mps", "error of v, m/s", 3});
  const Strip& finest = strips.strips.back();
  for (const Strip& strip : strips.strips) {
    const bool polygons = strip.level == kPolygonBin;
    const auto of_meeting = [&](double value) { return strip.met ? io::StudyCell(value) : io::StudyCell(); };
    std::vector<io::StudyCell>& row = table.rows.emplace_back();
    row.emplace_back(polygons ? std::string("polygons") : std::to_string(strip.level));
    row.push_back(polygons ? io::StudyCell() : io::StudyCell(strip.balls));
    row.push_back(of_meeting(strip.time_s));
    row.push_back(of_meeting(1000 * strip.gap_m));
    row.push_back(of_meeting(strip.gap_radii));
    row.push_back(finest.met ? of_meeting(1000 * (strip.time_s - finest.time_s)) : io::StudyCell());
    double error2 = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      for (int axis = 0; axis < 3; ++axis) row.emplace_back(strip.velocity_mps[i][axis]);
      row.emplace_back(strip.spin_radps[i].norm());
      error2 += (strip.velocity_mps[i] - finest.velocity_mps[i]).squaredNorm() / 2;
    }
    row.emplace_back(std::sqrt(error2));
  }
  return table;
}

void add_study_strips_options(CLI::App& command, StudyStripsOptions& o) {
  command
      .add_option("--scene", o.common.scene,
                  "A scene with two dynamic bodies that meet, by file or name (default: two jacks)")
      ->type_name("SCENE");
  std::vector<std::string_view> names;
  for (const simulation::NamedContactModel& model : simulation::kContactModels) names.emplace_back(model.name);
  command.add_option("--contact", o.contact, "Contact model: paper, wrench or fitted (default fitted)")
      ->check(one_of(names))
      ->type_name("MODEL");
  add_study_files(command, o.common, "Draw the strips as a PNG");
  add_path(command, "--svg", o.common.picture.svg,
           "Draw them as an SVG: flat colours, no shadows, light or dark as the browser prefers");
  command.footer(
      "Examples:\n"
      "  poise study strips --markdown strips.md --picture strips.png\n"
      "  poise study strips --scene two-body --json -\n\n"
      "One collision of two bodies, interrupted at each level: when it is answered, how far apart the surfaces are "
      "then, and how the bodies part.");
}

int study_strips(const StudyStripsOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound)
    return refuse("study strips", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  const Result<Scene> scene = scene_of(o);
  if (!scene) return refuse("study strips", scene.error());
  SceneRunOptions start;
  start.world.threads = static_cast<int>(o.common.threads.value_or(0));
  start.tree_cache = tree_cache_settings(o.common.tree_cache).value();
  for (const simulation::NamedContactModel& named : simulation::kContactModels) {
    if (o.contact == named.name) start.world.contact = named.model;
  }
  const Result<Strips> strips = collide(scene.value(), start);
  if (!strips) return refuse("study strips", strips.error());
  StudyTimesOptions without_plot = o.common;
  without_plot.picture = {};
  Status written = write_study(without_plot, strips_table(strips.value(), o), {}, std::string());
  const PlotFiles& files = o.common.picture;
  const auto draw = [&](const std::string& file, bool dark) {
    if (file.empty()) return;
    const Result<std::string> png = io::png_bytes(strips_picture(strips.value(), dark));
    add_failure(png ? io::write_file(file, png.value()) : Status(png.error()), written);
  };
  draw(files.png, false);
  draw(files.png_dark, true);
  if (!files.svg.empty()) add_failure(io::write_file(files.svg, strips_svg(strips.value())), written);
  return written ? kExitDone : refuse("study strips", written.error());
}

}  // namespace poise::app
