// SPDX-License-Identifier: MIT
#include <poise/world.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>
#include <vector>

// A game loop with Poise: frames on a fixed grid, physics that leaves time for game logic and rendering, a camera with
// a gaze that directs precision, and a report of late frames. Prints its figures and ends within three seconds. Late
// frames are no failure of this program; a World that refuses or loses a body is.
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;

constexpr int kFrames = 120;
constexpr std::chrono::nanoseconds kPeriod{16'666'667};  // 60 frames a second
constexpr microseconds kLogic{500};
constexpr microseconds kDrawing{4000};
constexpr int kBodies = 300;

/// Simulates the processor time of rendering a frame.
void burn(std::chrono::nanoseconds time) {
  for (const Clock::time_point end = Clock::now() + time; Clock::now() < end;) {
  }
}

poise::ShapePtr make_jack() {
  std::vector<poise::Sphere> spheres = {{poise::Vec3::Zero(), 0.28}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      spheres.push_back({side * 0.35 * poise::Vec3::Unit(axis), 0.22});
      spheres.push_back({side * 0.68 * poise::Vec3::Unit(axis), 0.18});
    }
  }
  return poise::make_spheres_shape(spheres).value();
}

/// Adds jacks on a loose grid above a tray of five planes. Returns the message if the World refuses one.
std::optional<std::string> fill(poise::World& world) {
  const poise::Result<poise::MaterialId> material = world.add_material({.restitution = 0.2, .friction = 0.5});
  if (!material) return material.error().message;
  std::vector<poise::BodyDefinition> definitions;
  const auto wall = [&](const poise::Vec3& normal, double offset_m) {
    poise::BodyDefinition body;
    body.shape = world.add_shape(poise::make_plane_shape(normal, offset_m).value());
    body.motion = poise::MotionType::Static;
    definitions.push_back(body);
  };
  wall({0, 0, 1}, 0);
  wall({1, 0, 0}, -6);
  wall({-1, 0, 0}, -6);
  wall({0, 1, 0}, -6);
  wall({0, -1, 0}, -6);
  const poise::ShapeId jack = world.add_shape(make_jack());
  for (int i = 0; i < kBodies; ++i) {
    poise::BodyDefinition body;
    body.shape = jack;
    body.position_m = {1.9 * (i % 6) - 4.75, 1.9 * (i / 6 % 6) - 4.75, 1.5 + 1.9 * (i / 36)};
    body.orientation = poise::Quat(Eigen::AngleAxisd(0.7 * i, poise::Vec3(1, 2, 3).normalized()));
    body.user_data = static_cast<std::uint64_t>(i);
    definitions.push_back(body);
  }
  for (poise::BodyDefinition& body : definitions) {
    body.material = material.value();
    const poise::Result<poise::BodyId> id = world.add_body(body);
    if (!id) return id.error().message;
  }
  return std::nullopt;
}

/// A camera that circles the pile; the player looks at the foot of the pile.
poise::View camera(double time_s) {
  poise::View view;
  view.present = true;
  view.position_m = {14 * std::cos(0.5 * time_s), 14 * std::sin(0.5 * time_s), 7};
  view.forward = (poise::Vec3(0, 0, 2) - view.position_m).normalized();
  view.up = (poise::Vec3::UnitZ() - view.forward.z() * view.forward).normalized();
  view.gaze = (poise::Vec3(0, 0, 0.5) - view.position_m).normalized();
  return view;
}

struct Report {
  std::array<int, 6> misses{};  // by cause
  std::chrono::nanoseconds slowest{0};
  std::size_t left = 0;  // pairs that the budget left at a coarse level
  int picked = 0;        // frames in which a body was under the gaze
};

const char* name_of(poise::MissCause cause) {
  switch (cause) {
    case poise::MissCause::None:
      return "on time";
    case poise::MissCause::Release:
      return "begun too late";
    case poise::MissCause::Infeasible:
      return "infeasible";
    case poise::MissCause::Machine:
      return "the machine was away";
    case poise::MissCause::Overrun:
      return "refinement overran";
    case poise::MissCause::Forecast:
      return "forecast too low";
  }
  return "";
}

bool run(poise::World& world, Report& report) {
  Clock::time_point release = Clock::now();
  for (int frame = 0; frame < kFrames; ++frame, release += kPeriod) {
    std::this_thread::sleep_until(release);
    burn(kLogic);  // input, scripts

    // Rendering must still happen before the frame ends, so its expected duration is reserved.
    poise::StepInput input;
    input.view = camera(frame / 60.0);
    input.host_work.learn = true;
    input.budget = poise::Budget::until(release + kPeriod);
    input.release = release + kLogic;  // the step cannot begin before
    const poise::FrameReport stepped = world.step(input);
    if (stepped.status != poise::StepStatus::Done) return false;

    // Finds the body under the gaze, for the game's own use.
    const auto hit = world.cast_ray({input.view.position_m, input.view.gaze});
    if (!hit) return false;
    report.picked += hit.value() ? 1 : 0;

    const Clock::time_point drawing = Clock::now();
    burn(kDrawing);
    world.report_host_work(Clock::now() - drawing);

    const bool late = Clock::now() > release + kPeriod;
    // If the step was in time and the rendering late, the reserve for rendering was too small.
    const poise::MissCause cause = !late                                     ? poise::MissCause::None
                                   : stepped.cause == poise::MissCause::None ? poise::MissCause::Forecast
                                                                             : stepped.cause;
    ++report.misses[static_cast<std::size_t>(cause)];
    report.slowest = std::max(report.slowest, stepped.times.total);
    report.left += stepped.pairs_left;
    // The grid does not move after a late frame: missed release times are skipped.
    while (release + kPeriod < Clock::now()) release += kPeriod;
  }
  return true;
}

}  // namespace

int main() {
  poise::WorldSettings settings;
  settings.gravity_mps2 = {0, 0, -9.81};
  settings.threads = 2;
  poise::Result<poise::World> world = poise::World::create(settings);
  if (!world) {
    std::fprintf(stderr, "game_loop: %s\n", world.error().message.c_str());
    return 1;
  }
  if (const std::optional<std::string> refused = fill(world.value())) {
    std::fprintf(stderr, "game_loop: %s\n", refused->c_str());
    return 1;
  }
  Report report;
  if (!run(world.value(), report)) {
    std::fprintf(stderr, "game_loop: a step or a query was refused\n");
    return 1;
  }
  std::printf("%d frames of %.1f ms with %d bodies, %.1f ms of drawing each\n", kFrames,
              1e-6 * static_cast<double>(kPeriod.count()), kBodies, 1e-3 * static_cast<double>(kDrawing.count()));
  for (std::size_t cause = 0; cause < report.misses.size(); ++cause) {
    if (report.misses[cause] > 0)
      std::printf("  %-22s %4d\n", name_of(static_cast<poise::MissCause>(cause)), report.misses[cause]);
  }
  std::printf("slowest step %.2f ms; %.1f pairs a frame left coarse; a body under the gaze in %d frames\n",
              1e-6 * static_cast<double>(report.slowest.count()), static_cast<double>(report.left) / kFrames,
              report.picked);
  for (const poise::BodyId body : world.value().bodies()) {
    const poise::Vec3 at = world.value().state(body).value().position_m;
    if (at.allFinite() && at.z() > -0.5 && std::abs(at.x()) < 7 && std::abs(at.y()) < 7) continue;
    std::fprintf(stderr, "game_loop: body %u left the tray\n", body.slot);
    return 1;
  }
  return 0;
}
