// SPDX-License-Identifier: MIT
#include "world_value.h"

#include <utility>

namespace poise::python {
namespace {

/// True as long as it lives.
class Busy {
 public:
  explicit Busy(bool& flag) : flag_(flag) { flag_ = true; }
  ~Busy() { flag_ = false; }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  bool& flag_;
};

void refuse(StepStatus status, const StepInput& input) {
  switch (status) {
    case StepStatus::RefusedTimeStep:
      raise(bad_input("dt_s = " + py::repr(py::float_(input.dt_s)).cast<std::string>() +
                      ", must be > 0 and at most 1000"));
    case StepStatus::RefusedView:
      raise(bad_input("view or attention: a component is not finite or out of range"));
    case StepStatus::RefusedHostWork:
      raise(
          bad_input("host_work_s = " + py::repr(py::float_(seconds_of(input.host_work.expected))).cast<std::string>() +
                    ", must be >= 0"));
    case StepStatus::RefusedReplay:
      raise(bad_input(
          "the record's frame belongs to a step with another number: its World was stepped by somebody else"));
    case StepStatus::Done:
    case StepStatus::ReplayDiffers:
      break;
  }
}

}  // namespace

WorldValue::WorldValue(const SettingsValue& settings) {
  auto world = std::make_shared<World>(taken(World::create(attached(settings))));
  world_ = world.get();
  owner_ = std::move(world);
}

WorldValue::WorldValue(std::shared_ptr<void> owner, World& world, const PolicyValue& policy)
    : owner_(std::move(owner)), world_(&world) {
  scheduler::Policy with = policy.policy;
  host_->cue = policy.cue;
  host_->policy = policy.custom;
  host_->attach(with);
  check(world.set_policy(with));
}

World& WorldValue::use() {
  if (busy_)
    raise(bad_input("the World is being stepped: a cue or another thread must not use it until the step has returned"));
  return *world_;
}

FrameReport WorldValue::step(StepInput input, const BudgetValue& budget) {
  World& world = use();
  FrameReport report;
  {
    const Busy busy(busy_);
    const WithoutLock others;
    // Here, so that waiting for the lock before takes nothing from it.
    input.budget = budget.resolved();
    report = world.step(input);
    // A thread that was held up in a function needs the lock, and whoever changes the World waits for that thread.
    world.wait_for_workers();
  }
  host_->rethrow();
  refuse(report.status, input);
  return report;
}

WorldSettings WorldValue::attached(const SettingsValue& to) {
  check_policy(to.policy);
  WorldSettings settings = to.settings;
  settings.policy = to.policy.policy;
  HostFunctions probe;
  probe.cue = to.policy.cue;
  probe.policy = to.policy.custom;
  probe.attach(settings.policy);
  if (settings.policy.cue.function != nullptr) settings.policy.cue.context = host_.get();
  if (settings.policy.custom.function != nullptr) settings.policy.custom.context = host_.get();
  host_->cue = to.policy.cue;
  host_->policy = to.policy.custom;
  return settings;
}

SettingsValue WorldValue::settings() {
  SettingsValue value;
  value.settings = use().settings();
  value.policy.policy = std::exchange(value.settings.policy, {});
  value.policy.policy.cue = {};
  value.policy.policy.custom = {};
  value.policy.cue = host_->cue;
  value.policy.custom = host_->policy;
  return value;
}

void WorldValue::set_settings(const SettingsValue& to) {
  const SettingsValue before = settings();
  const Status set = world_->set_settings(attached(to));
  if (set) return;
  host_->cue = before.policy.cue;
  host_->policy = before.policy.custom;
  raise(set.error());
}

void WorldValue::set_filter(const py::object& function) {
  if (!function.is_none() && PyCallable_Check(function.ptr()) == 0)
    raise(bad_input("function = " + py::repr(function).cast<std::string>() + ", must be a function or None"));
  World& world = use();
  host_->filter = function;
  world.set_pair_filter(function.is_none() ? PairFilter{} : PairFilter{call_filter, host_.get()});
}

ShapeId WorldValue::id_of(const ShapeValue& shape) {
  const auto known = shapes_.find(shape.shape.get());
  if (known != shapes_.end()) return known->second;
  return shapes_.emplace(shape.shape.get(), use().add_shape(shape.shape)).first->second;
}

void WorldValue::remove_shape(const ShapeValue& shape) {
  const auto known = shapes_.find(shape.shape.get());
  if (known == shapes_.end()) raise(bad_input("shape: this World has no such shape"));
  check(use().remove_shape(known->second));
  shapes_.erase(known);
}

std::shared_ptr<StateRows> WorldValue::states() {
  const World& world = use();
  std::vector<BodyId> bodies = world.bodies();
  if (!rows_ || rows_->bodies != bodies) {
    rows_ = std::make_shared<StateRows>();
    for (const BodyId body : bodies) {
      rows_->slot.push_back(body.slot);
      rows_->generation.push_back(body.generation);
    }
    rows_->position_m.resize(3 * bodies.size());
    rows_->orientation_wxyz.resize(4 * bodies.size());
    rows_->velocity_mps.resize(3 * bodies.size());
    rows_->angular_velocity_radps.resize(3 * bodies.size());
    rows_->bodies = std::move(bodies);
  }
  for (std::size_t i = 0; i < rows_->bodies.size(); ++i) {
    const BodyState state = taken(world.state(rows_->bodies[i]));
    const auto put = [i](std::vector<double>& to, const Vec3& v) {
      for (std::size_t k = 0; k < 3; ++k) to[3 * i + k] = v[static_cast<Eigen::Index>(k)];
    };
    put(rows_->position_m, state.position_m);
    put(rows_->velocity_mps, state.velocity_mps);
    put(rows_->angular_velocity_radps, state.angular_velocity_radps);
    rows_->orientation_wxyz[4 * i] = state.orientation.w();
    rows_->orientation_wxyz[4 * i + 1] = state.orientation.x();
    rows_->orientation_wxyz[4 * i + 2] = state.orientation.y();
    rows_->orientation_wxyz[4 * i + 3] = state.orientation.z();
  }
  return rows_;
}

}  // namespace poise::python
