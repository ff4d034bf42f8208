// SPDX-License-Identifier: MIT
#include "scene/import/mjcf_import.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <numbers>
#include <string>
#include <string_view>

#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using io::DraftBody;
using io::import_mjcf;
using io::SceneDraft;
using io::SolidKind;

constexpr double kMjcfPi = std::numbers::pi;

SceneDraft imported(const std::string& model, bool skip = false) {
  const Result<SceneDraft> draft = import_mjcf("<mujoco>" + model + "</mujoco>", "m.xml", "/nowhere", skip);
  EXPECT_TRUE(draft.ok()) << draft.error().message;
  return draft.value_or({});
}

SceneDraft world(const std::string& bodies) { return imported("<worldbody>" + bodies + "</worldbody>"); }

std::string mjcf_refusal(const std::string& model, bool skip = false) {
  const Result<SceneDraft> draft = import_mjcf("<mujoco>\n" + model + "</mujoco>", "m.xml", "/nowhere", skip);
  return draft.ok() ? "accepted" : draft.error().message;
}

const DraftBody& named(const SceneDraft& draft, std::string_view name) {
  for (const DraftBody& body : draft.bodies)
    if (body.name == name) return body;
  ADD_FAILURE() << name;
  return draft.bodies.front();
}

void expect_pose(const SceneDraft& draft, std::string_view name, const Vec3& position_m, const Quat& orientation) {
  const DraftBody& body = named(draft, name);
  EXPECT_LE((body.position_m - position_m).norm(), 2e-10) << name;
  EXPECT_GE(std::abs(body.orientation.dot(orientation)), 1 - 2e-10) << name;
}

// The poses are those that MuJoCo 2.2.2 (libmujoco, mj_kinematics) gives for this model, with ten decimals.
TEST(ImportMjcf, PlacesNestedFramesAsMuJoCoDoes) {
  const Result<SceneDraft> read =
      import_mjcf(contents(POISE_SOURCE_DIR "/tests/fuzz/seeds/mjcf/sound-frames.xml"), "m.xml", "/nowhere", false);
  ASSERT_TRUE(read.ok()) << read.error().message;
  const SceneDraft& draft = read.value();
  EXPECT_EQ(draft.name, "frames");
  EXPECT_EQ(draft.dt_s, 0.004);
  EXPECT_EQ(draft.gravity_mps2, Vec3(0, 1, -9));
  EXPECT_EQ(draft.bodies.size(), 11U);
  expect_pose(draft, "floor", {0, 0, -1}, {0.9937606692, 0.0997086509, 0.0049895912, 0.0497294816});
  expect_pose(draft, "a1", {1.2192303053, 2.0598255361, 3.2972523818},
              {0.3913320440, 0.8576302725, 0.2688606781, 0.1975942379});
  expect_pose(draft, "a2", {1, 2, 3}, {0.7833238031, 0.3827981368, 0.3183062642, 0.3722237608});
  expect_pose(draft, "b1", {1.2787742057, 2.0896423649, 2.7388809247},
              {0.8175451831, -0.0706458931, 0.5424750034, 0.1798607852});
  expect_pose(draft, "b2", {1.4543663281, 2.3301803318, 2.7750595511},
              {0.7337539848, 0.6085654659, 0.1600296580, -0.2562102106});
  expect_pose(draft, "b3", {1.4399615881, 2.1477601033, 2.8139872240},
              {0.2589354269, 0.1815631634, 0.6377594429, 0.7023177026});
  expect_pose(draft, "b4", {1.4399615881, 2.1477601033, 2.8139872240},
              {0.3225794828, 0.6797086063, 0.3135186138, -0.5793485709});
  expect_pose(draft, "b6", {2.3179222004, 3.3504499379, 2.9948803560},
              {0.6797086063, -0.3225794828, 0.5793485709, 0.3135186138});
  // A free body has its own frame, and all that is in it.
  const DraftBody& free = named(draft, "free");
  EXPECT_TRUE(free.dynamic);
  EXPECT_EQ(free.position_m, Vec3(0, 0, 2));
  ASSERT_EQ(free.solids.size(), 2U);
  const Vec3 second = free.position_m + free.orientation * free.solids[1].position_m;
  EXPECT_LE((second - Vec3(0.3706463000, 0.1411750050, 2.0371188220)).norm(), 2e-10);
  // As MuJoCo, which has 24 kg for the whole body.
  EXPECT_NEAR(free.mass_kg, 500 * (8 * 0.1 * 0.2 * 0.3 + kMjcfPi * 0.01 * 0.4 + 4.0 / 3 * kMjcfPi * 0.001), 1e-9);
  EXPECT_NEAR(named(draft, "ball").mass_kg, 3, 0);
}

TEST(ImportMjcf, HasHalfSizesOfEveryKindOfGeom) {
  const SceneDraft draft = world(
      "<geom name='s' size='0.5'/><geom name='c' type='capsule' size='0.1 0.4'/>"
      "<geom name='y' type='cylinder' size='0.1 0.4'/><geom name='e' type='ellipsoid' size='1 2 3'/>"
      "<geom name='b' type='box' size='1 2 3'/><geom name='p' type='plane' size='0 0 1'/>"
      "<geom name='f' type='cylinder' size='0.2' fromto='0 0 1  0 0 4'/>"
      "<geom name='g' type='box' size='0.2' fromto='0 0 1  0 0 4'/>");
  EXPECT_EQ(named(draft, "s").solids.at(0).half_m.x(), 0.5);
  EXPECT_EQ(named(draft, "c").solids.at(0).half_m, Vec3(0.1, 0.4, 0));
  EXPECT_EQ(named(draft, "c").solids.at(0).kind, SolidKind::Capsule);
  EXPECT_NEAR(io::volume_of(named(draft, "c").solids[0]), kMjcfPi * (0.008 + 0.004 / 3), 1e-15);
  EXPECT_NEAR(io::volume_of(named(draft, "y").solids.at(0)), kMjcfPi * 0.008, 1e-15);
  EXPECT_NEAR(io::volume_of(named(draft, "e").solids.at(0)), kMjcfPi * 8, 1e-12);
  EXPECT_EQ(io::volume_of(named(draft, "b").solids.at(0)), 48);
  EXPECT_TRUE(named(draft, "p").solids.empty()) << "a half-space";
  EXPECT_EQ(named(draft, "f").solids.at(0).half_m, Vec3(0.2, 1.5, 0));
  EXPECT_EQ(named(draft, "f").position_m, Vec3(0, 0, 2.5));
  EXPECT_EQ(named(draft, "g").solids.at(0).half_m, Vec3(0.2, 0.2, 1.5));
}

TEST(ImportMjcf, TurnsByTheSequenceOfItsCompiler) {
  const std::string body = "<worldbody><geom name='g' size='1' euler='90 90 0'/></worldbody>";
  const auto turned = [&](const std::string& compiler) {
    return Vec3(named(imported(compiler + body), "g").orientation * Vec3::UnitX());
  };
  // About x, then about the new y: x stays, then goes to the new -z, which is y.
  EXPECT_LE((turned("") - Vec3::UnitY()).norm(), 1e-15);
  // About the fixed axes: x stays, then goes to -z.
  EXPECT_LE((turned("<compiler eulerseq='XYZ'/>") + Vec3::UnitZ()).norm(), 1e-15);
  // About z, then about the new y.
  EXPECT_LE((turned("<compiler eulerseq='zyx'/>") + Vec3::UnitZ()).norm(), 1e-15);
  const std::string radians =
      "<compiler angle='radian'/><worldbody><geom name='g' size='1' "
      "axisangle='0 0 2 1.5707963267948966'/></worldbody>";
  EXPECT_LE((named(imported(radians), "g").orientation * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
}

TEST(ImportMjcf, InheritsFromClassesOfDefaults) {
  const SceneDraft draft = imported(
      "<default><geom friction='0.3' size='1'/><default class='a'><geom size='2'/><default class='b'>"
      "<geom condim='1'/></default></default></default><worldbody><geom name='0'/><geom name='1' class='b'/>"
      "<body childclass='a'><geom name='2'/><body><geom name='3' size='4'/></body><geom name='5' class='main'/>"
      "<body childclass='b'><geom name='6'/></body></body></worldbody>");
  const auto size = [&](std::string_view name) { return named(draft, name).solids.at(0).half_m.x(); };
  EXPECT_EQ(size("0"), 1);
  EXPECT_EQ(size("1"), 2);
  EXPECT_EQ(size("2"), 2);
  EXPECT_EQ(size("3"), 4);
  EXPECT_EQ(size("5"), 1);
  EXPECT_EQ(size("6"), 2);
  EXPECT_EQ(named(draft, "3").friction, 0.3);
  EXPECT_EQ(named(draft, "6").friction, 0) << "condim 1 has no friction";
}

TEST(ImportMjcf, ReadsWhatItIncludesOnce) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("a.xml")) << "<any><body pos='1 0 0'><include file='b.xml'/></body></any>";
  std::ofstream(folder.file("b.xml")) << "<any><geom name='g' size='1' pos='0 1 0'/></any>";
  const std::string begin = "<mujoco><worldbody><include file='a.xml'/>";
  const Result<SceneDraft> draft = import_mjcf(begin + "</worldbody></mujoco>", "m.xml", folder.path(), false);
  ASSERT_TRUE(draft.ok()) << draft.error().message;
  EXPECT_EQ(named(draft.value(), "g").position_m, Vec3(1, 1, 0));
  const auto twice =
      import_mjcf(begin + "\n<include file='b.xml'/></worldbody></mujoco>", "m.xml", folder.path(), false);
  EXPECT_EQ(twice.error().message, "m.xml: line 2: <include>: file = 'b.xml', may be included once");
  std::ofstream(folder.file("b.xml")) << "<any>\n<geom size='-1'/></any>";
  const auto bad = import_mjcf(begin + "</worldbody></mujoco>", "m.xml", folder.path(), false);
  EXPECT_EQ(bad.error().message,
            folder.file("b.xml") + ": line 2: <geom>: size = '-1', of a sphere must be 1 number, at least 1e-09");
}

/// Whether two bodies collide by their groups.
bool meet(const DraftBody& a, const DraftBody& b) {
  return (a.group & b.collides_with) != 0 && (b.group & a.collides_with) != 0;
}

TEST(ImportMjcf, KeepsWhichGeomsMayTouch) {
  // contype and conaffinity of each; two touch if the one's contype has a bit of the other's conaffinity.
  const SceneDraft draft = world(
      "<geom name='floor' size='1' contype='1' conaffinity='1'/><geom name='r' size='1' contype='1' conaffinity='0'/>"
      "<geom name='s' size='1' contype='0' conaffinity='2'/><geom name='t' size='1' contype='2' conaffinity='0'/>"
      "<geom name='seen' size='1' contype='0' conaffinity='0'/>");
  EXPECT_EQ(draft.bodies.size(), 4U) << "what is only seen is left out";
  EXPECT_TRUE(meet(named(draft, "floor"), named(draft, "r")));
  EXPECT_FALSE(meet(named(draft, "r"), named(draft, "r")));
  EXPECT_FALSE(meet(named(draft, "floor"), named(draft, "s")));
  EXPECT_TRUE(meet(named(draft, "s"), named(draft, "t")));
  EXPECT_FALSE(meet(named(draft, "r"), named(draft, "t")));
  EXPECT_EQ(world("<geom name='g' size='1'/>").bodies.at(0).collides_with, 0xffffffffU);
}

TEST(ImportMjcf, NamesWhatIsNotModelled) {
  const std::string model =
      "<worldbody><body name='arm'><joint type='slide'/>\n<joint/><geom name='g' size='1'/><body pos='0 0 1'><joint/>"
      "<geom name='h' size='1'/></body></body><body><composite/></body></worldbody>\n"
      "<actuator><motor/><motor/></actuator><sensor><gyro/></sensor><keyframe><key/></keyframe>";
  EXPECT_EQ(mjcf_refusal(model),
            "m.xml: not modelled: actuator/motor (2, first at line 4), slide joint (at line 2), hinge joint (2, first "
            "at line 3), composite in a body (at line 3); --skip-unmodelled leaves this out");
  const SceneDraft skipped = imported(model, true);
  ASSERT_EQ(skipped.warnings.size(), 1U);
  EXPECT_FALSE(named(skipped, "h").dynamic) << "fixed to what it hangs on";
  EXPECT_EQ(named(skipped, "h").position_m, Vec3(0, 0, 1));
  const auto free = [&](const std::string& geoms) {
    return mjcf_refusal("<worldbody><body><freejoint/>" + geoms + "</body></worldbody>");
  };
  const std::string end = " (at line 2); --skip-unmodelled leaves this out";
  const std::string ball = "<geom size='1'/>";
  EXPECT_EQ(free(ball + ball), "accepted");
  EXPECT_EQ(free(ball + "<geom size='1' density='1'/>"),
            "m.xml: not modelled: other density in the same free body" + end);
  EXPECT_EQ(free(ball + "<geom size='1' friction='2'/>"),
            "m.xml: not modelled: other friction in the same free body" + end);
  EXPECT_EQ(free(ball + "<geom size='1' contype='2'/>"),
            "m.xml: not modelled: other contype or conaffinity in the same free body" + end);
  EXPECT_EQ(free(ball + "<geom size='1' contype='0' conaffinity='0'/>"),
            "m.xml: not modelled: mass of a geom that collides with nothing" + end);
  EXPECT_EQ(free(ball + "<geom size='1' contype='0' conaffinity='0' mass='0'/>"), "accepted");
  EXPECT_EQ(free(ball + "<inertial pos='0 0 0' mass='2'/>"),
            "m.xml: not modelled: inertial of a free body, but for its mass" + end);
  EXPECT_EQ(imported("<worldbody><body><freejoint/><inertial mass='2'/>" + ball + "</body></worldbody>", true)
                .bodies.at(0)
                .mass_kg,
            2);
  EXPECT_EQ(free(""), "m.xml: not modelled: free body without a shape" + end);
}

TEST(ImportMjcf, IsRefusedWithPlaceAndRule) {
  const auto body = [](const std::string& inside) { return mjcf_refusal("<worldbody>" + inside + "</worldbody>"); };
  EXPECT_EQ(import_mjcf("<robot/>", "m.xml", "/nowhere", true).error().message,
            "m.xml: must be a model of MuJoCo, with a <mujoco>, not <robot>");
  EXPECT_EQ(import_mjcf("<mujoco>", "m.xml", "/nowhere", true).error().message,
            "m.xml: line 1: not valid XML (XML_ERROR_MISMATCHED_ELEMENT)");
  EXPECT_EQ(body("<geom/>"), "m.xml: line 2: <geom>: size = '', of a sphere must be 1 number, at least 1e-09");
  EXPECT_EQ(body("<geom type='box' size='1 2'/>"),
            "m.xml: line 2: <geom>: size = '1 2', of a box must be 3 numbers, at least 1e-09");
  EXPECT_EQ(body("<geom type='cone'/>"),
            "m.xml: line 2: <geom>: type = 'cone', must be plane, sphere, capsule, ellipsoid, cylinder, box, mesh, "
            "hfield or sdf");
  EXPECT_EQ(body("<geom size='1' pos='0 0'/>"),
            "m.xml: line 2: <geom>: pos = '0 0', must be 3 numbers within 1000000000");
  EXPECT_EQ(body("<geom size='1' quat='1 0 0 0' euler='0 0 0'/>"),
            "m.xml: line 2: <geom>: has quat and euler, must have one of them");
  EXPECT_EQ(body("<geom size='1' quat='0 0 0 0'/>"), "m.xml: line 2: <geom>: quat = '0 0 0 0', must not be zero");
  EXPECT_EQ(body("<geom size='1' class='x'/>"), "m.xml: line 2: <geom>: class = 'x', must be the class of a <default>");
  EXPECT_EQ(body("<geom type='mesh' mesh='x'/>"),
            "m.xml: line 2: <geom>: mesh = 'x', must be the name of a mesh of <asset>");
  EXPECT_EQ(body("<body><freejoint/><geom type='plane' size='1 1 1'/></body>"),
            "m.xml: line 2: <geom>: type = 'plane', must be in a body that does not move");
  EXPECT_EQ(body("<body><body><freejoint/></body></body>"),
            "m.xml: line 2: <body>: has a free joint, must be directly in <worldbody>");
  EXPECT_EQ(body("<body><freejoint/><geom size='1' mass='0'/></body>"),
            "m.xml: line 2: <body>: moves, must have a mass above 0");
  EXPECT_EQ(body("<geom size='1' mass='-1'/>"), "m.xml: line 2: <geom>: mass = '-1', must be at least 0");
  EXPECT_EQ(mjcf_refusal("<option timestep='0'/>"),
            "m.xml: line 2: <option>: timestep = '0', must be above 0 and at most 1");
  EXPECT_EQ(mjcf_refusal("<compiler eulerseq='xy'/>"),
            "m.xml: line 2: <compiler>: eulerseq = 'xy', must be three letters of x, y, z, X, Y and Z");
  EXPECT_EQ(mjcf_refusal("<include file='no.xml'/>"),
            "m.xml: line 2: <include>: file = 'no.xml': cannot be read: no such file");
  EXPECT_EQ(mjcf_refusal("<default><default/></default>"), "m.xml: line 2: <default>: must have a class");
  EXPECT_EQ(mjcf_refusal("<asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0' face='0 1 3'/></asset>"),
            "m.xml: line 2: <mesh>: face = '0 1 3', has '3', must have whole numbers below 3, of vertices");
}

TEST(ImportMjcf, NamesWhatMuJoCoDoesNotKnowAndWhatWouldChangeMotion) {
  const auto not_modelled = [](const std::string& model) {
    const std::string message = mjcf_refusal(model);
    const std::string begin = "m.xml: not modelled: ";
    const std::string end = " (at line 2); --skip-unmodelled leaves this out";
    EXPECT_TRUE(message.starts_with(begin) && message.ends_with(end)) << message;
    return message.substr(begin.size(), message.size() - std::min(message.size(), begin.size() + end.size()));
  };
  const auto body = [](const std::string& inside) {
    return "<worldbody><body><freejoint/>" + inside + "</body></worldbody>";
  };
  EXPECT_EQ(not_modelled("<option gravty='0 0 -1'/>"), "unknown attribute gravty of <option>");
  EXPECT_EQ(not_modelled("<compiler angel='radian'/>"), "unknown attribute angel of <compiler>");
  EXPECT_EQ(not_modelled(body("<geom typ='box' size='1'/>")), "unknown attribute typ of <geom>");
  EXPECT_EQ(not_modelled("<worldbody><body psition='0 0 5'/></worldbody>"), "unknown attribute psition of <body>");
  EXPECT_EQ(not_modelled(body("<geom size='1' shellinertia='true'/>")), "shellinertia of <geom>");
  EXPECT_EQ(not_modelled("<compiler boundmass='100'/>"), "boundmass of <compiler>");
  EXPECT_EQ(not_modelled("<compiler inertiagrouprange='0 2'/>"), "inertiagrouprange of <compiler>");
  EXPECT_EQ(not_modelled("<option><flag constraint='disable'/></option>"), "contacts switched off");
  EXPECT_EQ(not_modelled("<worldbody><body><joint type='free' damping='5'/><geom size='1'/></body></worldbody>"),
            "damping of a free joint");
  EXPECT_EQ(not_modelled("<default><joint damping='5'/></default>"
                         "<worldbody><body><joint type='free'/><geom size='1'/></body></worldbody>"),
            "damping of a free joint");
  imported(
      "<compiler boundmass='0.0' inertiafromgeom='true'/><compiler inertiafromgeom='auto'/>"
      "<default><joint damping='5'/></default><worldbody><body gravcomp='0.0'><freejoint/>"
      "<geom size='1' solref='0.1 1' rgba='1 0 0 1' euler='0 0 9'/></body>"
      "<geom type='hfield' hfield='h' contype='0' conaffinity='0'/></worldbody>");
  const SceneDraft weightless =
      imported("<option><flag gravity='disable'/></option><option gravity='0 0 -3'/><worldbody/>");
  EXPECT_TRUE(weightless.gravity_mps2.isZero(0)) << "whichever comes first";
}

TEST(ImportMjcf, WeighsABodyOfGivenAndOfUnknownMassesInAnyOrder) {
  const std::string cube =
      "<asset><mesh name='c' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 2 1 0 1 3 0 3 2 1 2 3'/></asset>";
  const auto body = [&](const std::string& geoms) {
    return imported(cube + "<worldbody><body name='b'><freejoint/>" + geoms + "</body></worldbody>", true);
  };
  const std::string given = "<geom type='mesh' mesh='c' mass='1'/>";
  const std::string light = "<geom type='mesh' mesh='c' density='0'/>";
  const std::string unknown = "<geom type='mesh' mesh='c' density='700' pos='2 0 0'/>";
  for (const std::string& geoms : {given + unknown, unknown + given, light + unknown}) {
    EXPECT_EQ(named(body(geoms), "b").density_kgpm3, 700) << geoms;
  }
}

}  // namespace
}  // namespace poise::testing
