// SPDX-License-Identifier: MIT
#include "assets/tree/urdf_robot.h"

#include <gtest/gtest.h>

#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "assets/tree/tree_files.h"

namespace poise::geometry {
namespace {

const std::string kRobot =
    "<?xml version=\"1.0\"?>\n"
    "<!-- <link name='no'><collision/></link> -->\r\n"
    "<robot name='r'>\n"
    "  <link name='a'> <!-- <collision> -->\n"
    "    <visual><geometry><sphere radius='9'/></geometry></visual>\n"
    "    <collision name='x>y'>\n"
    "      <origin xyz='1 2 3' rpy='0 0 1.5707963267948966'/>\n"
    "      <geometry><box size='2 4 6'/></geometry>\n"
    "    </collision>\n"
    "    <collision><geometry><mesh filename='package://p/m.obj' scale='1 1 -2'/></geometry></collision>\n"
    "  </link>\n"
    "  <link name=\"b\">\n"
    "    <visual><geometry><cylinder radius='1' length='4'/></geometry></visual>\n"
    "  </link>\n"
    "  <link name='c'/>\n"
    "  <link name='d'><collision><geometry><sphere radius='0.5'/></geometry></collision></link>\n"
    "  <joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\n"
    "</robot>\n";

TEST(UrdfRobot, HasTheShapesOfAllLinks) {
  const auto links = urdf_links(kRobot);
  ASSERT_TRUE(links.ok()) << links.error().message;
  ASSERT_EQ(links.value().size(), 4U);
  const UrdfLink& a = links.value()[0];
  EXPECT_EQ(a.name, "a");
  EXPECT_FALSE(a.from_visual) << "collision shapes go before visual ones";
  ASSERT_EQ(a.parts.size(), 2U);
  EXPECT_EQ(a.parts[0].solid, UrdfSolid::Box);
  EXPECT_EQ(a.parts[0].size_m, Vec3(2, 4, 6));
  EXPECT_EQ(a.parts[0].position_m, Vec3(1, 2, 3));
  EXPECT_LE((a.parts[0].rotation * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_EQ(a.parts[1].solid, UrdfSolid::Mesh);
  EXPECT_EQ(a.parts[1].file, "package://p/m.obj");
  EXPECT_EQ(a.parts[1].scale, Vec3(1, 1, -2));
  EXPECT_EQ(a.parts[1].line, 10);
  EXPECT_TRUE(links.value()[1].from_visual);
  EXPECT_EQ(links.value()[1].parts.at(0).size_m, Vec3(1, 4, 0));
  EXPECT_TRUE(links.value()[2].parts.empty());
  EXPECT_TRUE(links.value()[3].only_spheres());
  EXPECT_FALSE(a.only_spheres());
}

TEST(UrdfRobot, TurnsAboutFixedAxes) {
  constexpr double kQuarter = std::numbers::pi / 2;
  // First about x, then about the y and the z of the link.
  const Vec3 turned = rotation_of_rpy({kQuarter, kQuarter, 0}) * Vec3::UnitY();
  EXPECT_LE((turned - Vec3::UnitX()).norm(), 1e-15) << "y goes to z, and z to x";
}

TEST(UrdfRobot, GetsSpheresAndNothingElseChanges) {
  const std::vector<Sphere> two{{{1, 2, 3}, 0.5}, {{-1, 0.25, 1e-7}, 0.1}};
  const std::vector<Sphere> one{{{0, 0, 0}, 2}};
  const std::vector<std::optional<std::vector<Sphere>>> spheres{two, one, std::nullopt, std::nullopt};
  const auto written = with_collision_spheres(kRobot, spheres);
  ASSERT_TRUE(written.ok()) << written.error().message;
  const auto line = [](const char* xyz, const char* radius) {
    return std::string("<collision><origin xyz=\"") + xyz + "\" rpy=\"0 0 0\"/><geometry><sphere radius=\"" + radius +
           "\"/></geometry></collision>";
  };
  std::string expected = kRobot;
  const std::size_t begin = expected.find("<collision name=");
  const std::size_t end = expected.find("\n  </link>", begin);
  expected.replace(begin, end - begin, line("1 2 3", "0.5") + "\n    " + line("-1 0.25 1e-07", "0.1"));
  const std::size_t behind = expected.find("  </link>\n  <link name='c'/>");
  expected.insert(behind, "    " + line("0 0 0", "2") + "\n");
  EXPECT_EQ(written.value(), expected);
  const auto read = urdf_spheres(written.value(), {"a", {}});
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().size(), 2U);
  EXPECT_EQ(read.value()[1].center_m, two[1].center_m);
  EXPECT_EQ(read.value()[1].radius_m, two[1].radius_m);
  EXPECT_EQ(urdf_spheres(written.value(), {"b", {}}).value().size(), 1U);
}

// Found by a fuzzer: of two roots the parser reads the first.
TEST(UrdfRobot, IsNotWrittenWhereItsLinksCannotBeToldApart) {
  const std::string robot =
      "<robot><link name='a'><collision><geometry><sphere radius='1'/></geometry></collision></link></robot>";
  const std::vector<std::optional<std::vector<Sphere>>> one{std::vector<Sphere>{{{0, 0, 0}, 2}}};
  EXPECT_TRUE(with_collision_spheres(robot, one).ok());
  EXPECT_EQ(with_collision_spheres(robot + robot, one).error().message,
            "cannot be written back: its links cannot be told apart");
}

TEST(UrdfRobot, IsRefusedWithLineAndRule) {
  const auto refused = [](const std::string& inside) {
    const auto links = urdf_links("<robot>\n" + inside + "\n</robot>");
    return links.ok() ? "accepted" : links.error().message;
  };
  const auto shape = [&](const std::string& text) {
    return refused("<link name='a'><collision><geometry>" + text + "</geometry></collision></link>");
  };
  EXPECT_EQ(urdf_links("<sdf/>").error().message, "must be a URDF with a <robot>");
  EXPECT_EQ(urdf_links("<robot>").error().message, "line 1: not valid XML (XML_ERROR_MISMATCHED_ELEMENT)");
  EXPECT_EQ(refused(""), "has no <link>");
  EXPECT_EQ(refused("<link/>"), "line 2: <link>: must have a name");
  EXPECT_EQ(refused("<link name='a'/><link name='a'/>"), "line 2: <link>: name 'a' is that of another link");
  EXPECT_EQ(refused("<xacro:arm/>"),
            "line 2: <xacro:arm>: is a macro of xacro, must be expanded before (xacro robot.xacro > robot.urdf)");
  EXPECT_EQ(refused("<link name='a'><visual/></link>"), "line 2: <visual>: must have a <geometry> with a shape");
  EXPECT_EQ(shape("<cone/>"), "line 2: <cone>: is no shape of URDF, must be mesh, box, cylinder or sphere");
  EXPECT_EQ(shape("<box size='1 2'/>"), "line 2: <box>: size = '1 2', must be 3 numbers within 1000000000");
  EXPECT_EQ(shape("<box size='1 2 0'/>"), "line 2: <box>: size = 0, must be at least 1e-09 m");
  EXPECT_EQ(shape("<sphere/>"), "line 2: <sphere>: radius = '', must be 1 number within 1000000000");
  EXPECT_EQ(shape("<mesh/>"), "line 2: <mesh>: filename must name a mesh");
  EXPECT_EQ(shape("<mesh filename='a' scale='1 0 1'/>"), "line 2: <mesh>: scale must not be 0 along any axis");
}

}  // namespace
}  // namespace poise::geometry
