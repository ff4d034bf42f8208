// SPDX-License-Identifier: MIT
#include "soak/soak_drive.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "scene/generators.h"
#include "soak/counted_memory.h"

namespace poise::soak {
namespace {

// All chosen: scenes/pour.json, which ends after its 900 frames, and what a viewer may do.
constexpr std::uint64_t kFramesOfFilling = 480;
constexpr std::uint64_t kFramesOfBudget = 120;
constexpr std::array<double, 3> kBudgets{1, 0.25, 2};
constexpr std::uint64_t kFramesOfGaze = 40;
constexpr int kStaleAsked = 8;

SceneRunOptions options_of(const Scene& scene, ExecutorKind executor, int threads) {
  SceneRunOptions options;
  options.world.policy = scene.policy;
  options.world.executor = executor;
  options.world.threads = threads;
  return options;
}

}  // namespace

SoakDrive::SoakDrive(const Scene& scene, const SoakSettings& settings, const StreamGenerator& stream, SceneRun first,
                     SceneRun second)
    : scene_(scene),
      settings_(settings),
      stream_(stream),
      first_(std::move(first)),
      second_(std::move(second)),
      random_(settings.seed) {
  const double life_frames = *stream.life_s / scene.dt_s;
  const double a_frame = settings.per_second * scene.dt_s;
  present_.resize(static_cast<std::size_t>(std::ceil((life_frames + 2) * (a_frame + 1))));
}

Result<SoakDrive> SoakDrive::create(const Scene& scene, const SoakSettings& settings) {
  const StreamGenerator* stream =
      scene.generators.size() == 1 ? std::get_if<StreamGenerator>(&scene.generators.front()) : nullptr;
  if (stream == nullptr || !stream->life_s || !scene.camera)
    return bad_input(scene.source + ": needs a camera and one stream whose bodies have a life");
  Scene empty = scene;
  empty.generators.clear();
  Result<SceneRun> first = SceneRun::create(empty, options_of(scene, ExecutorKind::Threads, settings.threads));
  if (!first) return first.error();
  Result<SceneRun> second = first.value().again(options_of(scene, ExecutorKind::Serial, 1));
  if (!second) return second.error();
  SoakDrive made(empty, settings, *stream, std::move(first).value(), std::move(second).value());
  for (World* world : {&made.first_.world(), &made.second_.world()}) {
    const Status added = made.add_kinds(*world);
    if (!added) return added.error();
  }
  return made;
}

Status SoakDrive::add_kinds(World& world) {
  shapes_.clear();
  materials_.clear();
  for (std::size_t i = 0; i < scene_.shapes.size(); ++i) shapes_.push_back(world.add_shape(first_.shapes()[i]));
  for (const SceneMaterial& material : scene_.materials) {
    const Result<MaterialId> id = world.add_material(material.material);
    if (!id) return id.error();
    materials_.push_back(id.value());
  }
  return Done{};
}

Status SoakDrive::remove_due() {
  for (; present_count_ > 0 && present_[first_present_].leaves <= counts_.frames; --present_count_) {
    const BodyId id = present_[first_present_].id;
    first_present_ = (first_present_ + 1) % present_.size();
    for (World* world : {&first_.world(), &second_.world()}) {
      const Status removed = world->remove_body(id);
      if (!removed) return removed;
    }
    ++counts_.removed;
    left_[left_count_ < left_.size() ? left_count_++ : random_.below(left_.size())] = id;
  }
  return Done{};
}

Status SoakDrive::add_due() {
  if (counts_.frames % kCycle >= kFramesOfFilling) return Done{};
  owed_ += settings_.per_second * scene_.dt_s;
  for (; owed_ >= 1 && present_count_ < present_.size(); --owed_) {
    const io::GeneratedBody drawn = io::draw_body(stream_.kind, counts_.added, random_);
    BodyDefinition body;
    body.shape = shapes_[drawn.shape];
    body.material = materials_[stream_.kind.material];
    const Vec3 part(random_.unit(), random_.unit(), random_.unit());
    body.position_m = stream_.region_min_m + part.cwiseProduct(stream_.region_max_m - stream_.region_min_m);
    body.orientation = drawn.orientation;
    body.velocity_mps = drawn.velocity_mps;
    body.angular_velocity_radps = drawn.angular_velocity_radps;
    const Result<BodyId> id = first_.world().add_body(body);
    if (!id) return id.error();
    const Result<BodyId> again = second_.world().add_body(body);
    if (!again) return again.error();
    if (again.value() != id.value()) return bad_input("the replay gave a body another handle");
    const auto life = static_cast<std::uint64_t>(std::lround(*stream_.life_s / scene_.dt_s));
    present_[(first_present_ + present_count_++) % present_.size()] = {id.value(), counts_.frames + life};
    ++counts_.added;
    if (id.value().slot < counts_.slots) ++counts_.recycled;
    counts_.slots = std::max<std::uint64_t>(counts_.slots, id.value().slot + 1ULL);
  }
  counts_.most_at_once = std::max<std::uint64_t>(counts_.most_at_once, present_count_);
  return Done{};
}

void SoakDrive::ask_stale() {
  if (left_count_ == 0) return;
  World& world = first_.world();
  for (int i = 0; i < kStaleAsked; ++i) {
    const BodyId id = left_[random_.below(left_count_)];
    const Result<BodyState> state = world.state(id);
    const Status set = world.set_state(id, {});
    const Status removed = world.remove_body(id);
    const auto refused = [](const auto& result) { return !result && result.error().kind == ErrorKind::StaleHandle; };
    counts_.stale_asked += 3;
    counts_.stale_accepted += 3U - static_cast<unsigned>(refused(state)) - static_cast<unsigned>(refused(set)) -
                              static_cast<unsigned>(refused(removed));
  }
}

StepInput SoakDrive::input() {
  if (counts_.frames % kFramesOfGaze == 0)
    looked_at_m_ = 0.5 * first_.tray_side_m() * Vec3(random_.symmetric(), random_.symmetric(), 0);
  StepInput input;
  input.dt_s = scene_.dt_s;
  input.view = first_.view();
  input.view.gaze = (looked_at_m_ - input.view.position_m).normalized();
  input.max_level = scene_.max_level;
  input.polygons = scene_.polygons;
  input.backtracking = scene_.backtracking;
  input.measure_energy = true;
  return input;
}

Budget SoakDrive::budget() const {
  const double share = kBudgets[counts_.frames / kFramesOfBudget % kBudgets.size()];
  if (settings_.work) return Budget::work(static_cast<std::uint64_t>(share * static_cast<double>(*settings_.work)));
  return Budget::within(Nanoseconds(std::llround(share * static_cast<double>(settings_.deadline.count()))));
}

Result<SoakFrame> SoakDrive::step() {
  Status done = remove_due();
  if (done) done = add_due();
  if (!done) return done.error();
  ask_stale();
  StepInput input = this->input();
  SoakFrame frame;
  input.record = true;
  input.budget = budget();
  const std::uint64_t before = allocations();
  frame.report = first_.world().step(input);
  frame.allocations = allocations() - before;
  first_.world().decisions(decisions_);
  input.record = false;
  input.budget = Budget::unlimited();
  input.replay = &decisions_;
  const FrameReport again = second_.world().step(input);
  frame.same = frame.report.status == StepStatus::Done && again.status == StepStatus::Done &&
               first_.world().state_hash() == second_.world().state_hash();
  counts_.out_of_range += frame.report.out_of_range;
  ++counts_.frames;
  return frame;
}

}  // namespace poise::soak
