// SPDX-License-Identifier: MIT
#include "accuracy/refusals.h"

#include <array>
#include <cmath>
#include <limits>

#include "accuracy/small_world.h"
#include "poise/scene/scene.h"

namespace poise::accuracy {
namespace {

constexpr std::array kNotFinite = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                                   -std::numeric_limits<double>::infinity()};

struct Tally {
  double tried = 0, taken = 0;
  void expect_refused(bool taken_in) {
    ++tried;
    taken += taken_in ? 1 : 0;
  }
};

void try_states(SmallWorld& world, BodyId body, Tally& tally) {
  for (const double bad : kNotFinite) {
    const Vec3 v(0, bad, 0);
    for (int part = 0; part < 4; ++part) {
      BodyState state = world.at(body);
      if (part == 0) state.position_m = v;
      if (part == 1) state.velocity_mps = v;
      if (part == 2) state.angular_velocity_radps = v;
      if (part == 3) state.orientation = Quat(1, bad, 0, 0);
      tally.expect_refused(world.world().set_state(body, state).ok());
    }
    tally.expect_refused(world.world().apply_force(body, v, Vec3::Zero()).ok());
    tally.expect_refused(world.world().apply_force(body, Vec3::Zero(), v).ok());
    tally.expect_refused(world.world().apply_torque(body, v).ok());
    tally.expect_refused(world.world().apply_impulse(body, v, Vec3::Zero()).ok());
    tally.expect_refused(world.world().set_importance(body, bad).ok());
  }
  BodyState state = world.at(body);
  state.orientation = Quat(0, 0, 0, 0);
  tally.expect_refused(world.world().set_state(body, state).ok());
}

void try_bodies(SmallWorld& world, ShapeId ball, Tally& tally) {
  const auto try_body = [&](const auto& change) {
    BodyDefinition body;
    body.shape = ball;
    change(body);
    const int before = world.refusals();
    world.add(body);
    tally.expect_refused(world.refusals() == before);
  };
  for (const double bad : kNotFinite) {
    try_body([&](BodyDefinition& b) { b.position_m.x() = bad; });
    try_body([&](BodyDefinition& b) { b.velocity_mps.y() = bad; });
    try_body([&](BodyDefinition& b) { b.angular_velocity_radps.z() = bad; });
    try_body([&](BodyDefinition& b) { b.orientation.w() = bad; });
    try_body([&](BodyDefinition& b) { b.mass_kg = bad; });
    try_body([&](BodyDefinition& b) { b.inertia_kgm2 = Vec3(1, bad, 1); });
    try_body([&](BodyDefinition& b) { b.importance = bad; });
  }
  try_body([](BodyDefinition& b) { b.mass_kg = -1; });
  try_body([](BodyDefinition& b) { b.orientation = Quat(0, 0, 0, 0); });
  try_body([](BodyDefinition& b) { b.inertia_kgm2 = Vec3(1, 1, 3); });
  try_body([](BodyDefinition& b) { b.inertia_kgm2 = Vec3(1, 0, 1); });
  try_body([](BodyDefinition& b) { b.shape = ShapeId{77}; });
  try_body([&](BodyDefinition& b) { b.shape = world.world().add_shape(make_plane_shape(Vec3::UnitZ(), 0).value()); });
  for (const Material& bad :
       {Material{-0.1, 0, 1}, Material{1.1, 0, 1}, Material{0, -1, 1}, Material{0, 0, 0}, Material{std::nan(""), 0, 1},
        Material{0, std::nan(""), 1}, Material{0, 0, std::nan("")}}) {
    tally.expect_refused(world.world().add_material(bad).ok());
  }
}

void try_steps(SmallWorld& world, Tally& tally) {
  for (const double bad : {0.0, -1.0 / 60, 1e9, kNotFinite[0], kNotFinite[1], kNotFinite[2]}) {
    tally.expect_refused(world.step(bad).status == StepStatus::Done);
  }
  StepInput input;
  input.view.present = true;
  input.view.position_m.x() = kNotFinite[0];
  tally.expect_refused(world.world().step(input).status == StepStatus::Done);
}

void try_scenes(Tally& tally) {
  const auto scene = [](const std::string& body, const std::string& density) {
    return R"({"name": "bad", "dt_s": 0.01, "materials": {"m": {"density_kgpm3": )" + density +
           R"(}}, "shapes": {"s": {"sphere": {"radius_m": 1}}}, "bodies": [{"shape": "s", "material": "m")" + body +
           "}]}";
  };
  const auto taken = [&](const std::string& body, const std::string& density) {
    return parse_scene(scene(body, density), "bad", ".").ok();
  };
  tally.expect_refused(taken(R"(, "mass_kg": 0)", "1"));
  tally.expect_refused(taken(R"(, "mass_kg": -1)", "1"));
  tally.expect_refused(taken(R"(, "mass_kg": 1e400)", "1"));
  tally.expect_refused(taken(R"(, "inertia_kgm2": [0, 1, 1])", "1"));
  tally.expect_refused(taken(R"(, "velocity_mps": [NaN, 0, 0])", "1"));
  tally.expect_refused(taken(R"(, "orientation_wxyz": [0, 0, 0, 0])", "1"));
  tally.expect_refused(taken("", "0"));
  // The same scene without the fault must be accepted, so that the refusal is due to the fault.
  tally.expect_refused(!taken("", "1"));
}

}  // namespace

Status bad_states(Context& context) {
  SmallWorld world(context, {0, 0, -kGravityMps2}, {0.5, 0, 1000});
  const ShapeId ball = world.ball(0.5);
  const BodyId body = world.add(ball, {0, 0, 3}, {1, 0, 0});
  world.step(1.0 / 60);
  const std::uint64_t before = world.world().state_hash();
  Tally tally;
  try_states(world, body, tally);
  try_bodies(world, ball, tally);
  try_steps(world, tally);
  try_scenes(tally);
  context.add("bad inputs tried", "", tally.tried, {});
  context.add("bad inputs that were taken", "", tally.taken, 0);
  context.add("bodies that changed by what was refused", "", world.world().state_hash() == before ? 0 : 1, 0);
  world.step(1.0 / 60);
  context.add("bodies not finite in the next step", "", world.at(body).position_m.allFinite() ? 0 : 1, 0);
  return context.at(1);
}

}  // namespace poise::accuracy
