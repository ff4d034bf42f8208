// SPDX-License-Identifier: MIT
#include "poise/assets/tree_formats.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <fstream>

#include <nlohmann/json.hpp>

#include "meshes.h"
#include "poise/assets/sph_file.h"
#include "scene/temporary_folder.h"

namespace poise {
namespace {

namespace fs = std::filesystem;
using testing::contents;
using testing::TemporaryFolder;

/// Nine spheres with awkward numbers, three levels with leaves above the deepest.
SphereTree small_tree() {
  std::vector<Sphere> spheres;
  for (int i = 0; i < 9; ++i) spheres.push_back({Vec3(i / 3.0, -1e-7 * i, 1e6 * i), 0.1 + 1e-9 * i});
  SphereTree tree = tree_of_spheres(spheres).value();
  for (std::size_t i = 0; i < tree.node_count(); ++i) tree.protrusion_max_m[i] = static_cast<float>(i);
  return tree;
}

std::vector<Sphere> spheres_at(const SphereTree& tree, Level level) {
  std::vector<Sphere> spheres;
  for (const NodeIndex node : tree.nodes_at(level)) spheres.push_back(tree.sphere(node));
  return spheres;
}

bool equal(const std::vector<Sphere>& a, const std::vector<Sphere>& b) {
  return std::ranges::equal(
      a, b, [](const Sphere& x, const Sphere& y) { return x.center_m == y.center_m && x.radius_m == y.radius_m; });
}

class TreeFormats : public ::testing::Test {
 protected:
  std::string refusal(const std::string& name, const std::string& text, const SphereChoice& choice = {}) const {
    std::ofstream(folder_.path() / name, std::ios::binary | std::ios::trunc) << text;
    const auto read = read_spheres(folder_.path() / name, choice);
    return read ? "not refused" : read.error().message;
  }
  fs::path file(const std::string& name) const { return folder_.path() / name; }
  TemporaryFolder folder_;
};

TEST(TreeFormatOf, GoesByTheEnding) {
  EXPECT_EQ(tree_format_of("a.sph"), TreeFormat::Sph);
  EXPECT_EQ(tree_format_of("b/a.b.URDF"), TreeFormat::Urdf);
  EXPECT_EQ(tree_format_of("a.yml"), TreeFormat::CuroboYaml);
  EXPECT_EQ(tree_format_of("a.yaml"), TreeFormat::CuroboYaml);
  EXPECT_EQ(tree_format_of("a.Json"), TreeFormat::FoamJson);
  for (const char* other : {"a", "a.obj", "json", "a.json.gz", ""})
    EXPECT_EQ(tree_format_of(other), std::nullopt) << other;
}

TEST_F(TreeFormats, EveryLevelComesBackExactlyFromEveryFormat) {
  const SphereTree tree = small_tree();
  for (const char* name : {"a.sph", "a.urdf", "a.yml", "a.json"}) {
    for (Level level = 0; level <= tree.depth(); ++level) {
      const TreeFormat format = *tree_format_of(name);
      ASSERT_TRUE(write_tree(tree, level, format, "link", file(name)));
      SphereChoice choice;
      if (format == TreeFormat::Sph || format == TreeFormat::FoamJson) choice.level = level;
      const auto read = read_spheres(file(name), choice);
      ASSERT_TRUE(read) << read.error().message;
      EXPECT_TRUE(equal(read.value(), spheres_at(tree, level))) << name << " level " << int{level};
    }
  }
  ASSERT_TRUE(write_tree(tree, 6, TreeFormat::Urdf, "link", file("deep.urdf")));
  EXPECT_TRUE(equal(read_spheres(file("deep.urdf")).value(), spheres_at(tree, tree.depth())))
      << "below the deepest level, the leaves";
}

TEST_F(TreeFormats, UrdfLooksLikeThis) {
  const SphereTree tree = tree_of_spheres(std::vector<Sphere>{{Vec3(0.5, -1, 1e-5), 0.25}}).value();
  ASSERT_TRUE(write_tree(tree, 0, TreeFormat::Urdf, "a <b> & \"c\"", file("a.urdf")));
  EXPECT_EQ(contents(file("a.urdf")),
            "<?xml version=\"1.0\"?>\n"
            "<robot name=\"a &lt;b&gt; &amp; &quot;c&quot;\">\n"
            "    <link name=\"a &lt;b&gt; &amp; &quot;c&quot;\">\n"
            "        <collision>\n"
            "            <origin xyz=\"0.5 -1 9.999999747378752e-06\" rpy=\"0 0 0\"/>\n"
            "            <geometry>\n"
            "                <sphere radius=\"0.25\"/>\n"
            "            </geometry>\n"
            "        </collision>\n"
            "    </link>\n"
            "</robot>\n");
}

TEST_F(TreeFormats, CuroboLooksLikeThis) {
  const SphereTree tree =
      tree_of_spheres(std::vector<Sphere>{{Vec3(0.5, -1, 0x1p-40), 0.25}, {Vec3(1, 0, 1e9), 0.5}}).value();
  ASSERT_TRUE(write_tree(tree, 1, TreeFormat::CuroboYaml, "no: \"arm\"", file("a.yml")));
  EXPECT_EQ(contents(file("a.yml")),
            "collision_spheres:\n"
            "  \"no: \\\"arm\\\"\":\n"
            "    - center: [0.5, -1, 9.094947017729282e-13]\n"
            "      radius: 0.25\n"
            "    - center: [1, 0, 1000000000]\n"
            "      radius: 0.5\n");
}

TEST_F(TreeFormats, YamlNumbersWithAnExponentHaveAPoint) {
  const SphereTree tree = tree_of_spheres(std::vector<Sphere>{{Vec3(0x1p-24, 0, 0), 1}}).value();
  ASSERT_TRUE(write_tree(tree, 0, TreeFormat::CuroboYaml, "a", file("a.yml")));
  const std::string text = contents(file("a.yml"));
  const std::size_t exponent = text.find("e-");
  ASSERT_NE(exponent, std::string::npos) << text;
  EXPECT_NE(text.rfind('.', exponent), std::string::npos) << text;
}

TEST_F(TreeFormats, FoamHoldsTheLevelsUpToTheChosenOneWithTheirErrors) {
  const SphereTree tree = small_tree();
  ASSERT_TRUE(write_tree(tree, 1, TreeFormat::FoamJson, "", file("a.json")));
  const auto json = nlohmann::json::parse(contents(file("a.json")));
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json[0]["spheres"].size(), 1U);
  const auto nodes = tree.nodes_at(1);
  ASSERT_EQ(json[1]["spheres"].size(), nodes.size());
  EXPECT_EQ(json[1]["best"], 1.0);
  EXPECT_EQ(json[1]["worst"], static_cast<double>(nodes.size()));
  EXPECT_NEAR(json[1]["mean"].get<double>(), 0.5 * (1 + static_cast<double>(nodes.size())), 1e-12);
  EXPECT_EQ(json[1]["spheres"][0]["radius"], tree.sphere(1).radius_m);
  EXPECT_EQ(json[1]["spheres"][0]["origin"][2], tree.sphere(1).center_m.z());
  EXPECT_EQ(json[1].size(), 4U);
}

TEST_F(TreeFormats, FoamSaysNullForErrorsThatNobodyMeasured) {
  ASSERT_TRUE(write_tree(small_tree(), 0, TreeFormat::Sph, "", file("a.sph")));
  ASSERT_TRUE(write_tree(read_sph(file("a.sph")).value(), 1, TreeFormat::FoamJson, "", file("a.json")));
  const auto json = nlohmann::json::parse(contents(file("a.json")));
  for (const char* figure : {"mean", "best", "worst"}) EXPECT_TRUE(json.at(1).at(figure).is_null()) << figure;
  EXPECT_TRUE(read_spheres(file("a.json"), {.level = Level{1}}));
}

TEST_F(TreeFormats, ANameThatSomeFormatCannotHoldIsRefused) {
  const SphereTree tree = small_tree();
  const std::vector<std::pair<std::string, std::string>> cases{{"", "must not be empty"},
                                                               {std::string(257, 'a'), "has 257 bytes, at most 256"},
                                                               {"a\nb", "control characters"},
                                                               {std::string("a\0b", 3), "control characters"},
                                                               {"\x7f", "control characters"},
                                                               {"\xc2\x85", "control characters"},
                                                               {"\xef\xbf\xbf", "control characters"},
                                                               {"\xff", "must be UTF-8"},
                                                               {"\xc3", "must be UTF-8"},
                                                               {"\xc0\xaf", "must be UTF-8"},
                                                               {"\xed\xa0\x80", "must be UTF-8"},
                                                               {"\xf4\x90\x80\x80", "must be UTF-8"}};
  for (const TreeFormat format : {TreeFormat::Urdf, TreeFormat::CuroboYaml}) {
    for (const auto& [name, rule] : cases) {
      const Status written = write_tree(tree, 0, format, name, file("a.out"));
      ASSERT_FALSE(written) << rule;
      EXPECT_NE(written.error().message.find(rule), std::string::npos) << written.error().message;
    }
  }
  for (const char* name :
       {"\xc3\xa4rm", "\xe8\x87\x82", "\xf0\x9f\xa4\x96", "true", "12", "- x", "#", "a]]>b", "&amp;"}) {
    for (const char* out : {"a.urdf", "a.yml"}) {
      ASSERT_TRUE(write_tree(tree, 0, *tree_format_of(out), name, file(out)));
      EXPECT_TRUE(read_spheres(file(out), {.link = name})) << name;
    }
  }
  EXPECT_EQ(folder_.entries(), 2U);
}

TEST_F(TreeFormats, AFileThatCannotBeWrittenIsAnOutputThatFailed) {
  for (const char* name : {"a.sph", "a.urdf", "a.yml", "a.json"}) {
    const Status written = write_tree(small_tree(), 0, *tree_format_of(name), "a", folder_.path() / "missing" / name);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().kind, ErrorKind::OutputFailed);
    EXPECT_FALSE(write_tree({}, 0, *tree_format_of(name), "a", file(name)));
  }
  EXPECT_EQ(folder_.entries(), 0U);
}

TEST_F(TreeFormats, ARobotOfManyLinksNeedsAChoice) {
  const std::string urdf =
      "<robot name='r'><link name='base'/><link name='arm'><collision><geometry><sphere radius=' 2 "
      "'/></geometry></collision></link>"
      "<link name='hand'><collision><origin rpy='1 2 3' xyz='1 +2 3e0'/><geometry><sphere "
      "radius='0.5'/></geometry></collision></link>"
      "</robot>";
  const std::string yaml =
      "robot_cfg:\n  kinematics:\n    collision_spheres:\n      arm: [{center: [0, 0, 0], radius: 2}]\n      none: []\n"
      "      hand:\n      - center: [1, 2.0, 3]\n        radius: 0.5\n";
  for (const auto& [name, text] : {std::pair{"a.urdf", urdf}, std::pair{"a.yml", yaml}}) {
    EXPECT_NE(refusal(name, text).find("several links have spheres, one must be chosen: arm, hand"), std::string::npos)
        << refusal(name, text);
    EXPECT_NE(refusal(name, text, {.link = "leg"}).find("no link 'leg' with spheres; there are: arm, hand"),
              std::string::npos);
    const auto hand = read_spheres(file(name), {.link = "hand"});
    ASSERT_TRUE(hand) << hand.error().message;
    EXPECT_TRUE(equal(hand.value(), {{Vec3(1, 2, 3), 0.5}}));
  }
}

TEST_F(TreeFormats, EachBrokenUrdfIsRefusedWithItsPlace) {
  const auto link = [](const std::string& inside) { return "<robot><link name='a'>\n" + inside + "</link></robot>"; };
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "not valid XML"},
      {"<robot><link>", "not valid XML"},
      {"<model/>", "must be a URDF with a <robot>"},
      {"<robot><link name='a'/></robot>", "no link has spheres"},
      {"<robot><link><collision/></link></robot>", "line 1: <link>: must have a name"},
      {link("<collision/>"), "line 2: <collision>: must have a <geometry>"},
      {link("<collision><geometry/></collision>"), "must have a <geometry> with a shape"},
      {link("<collision><geometry><box size='1 1 1'/></geometry></collision>"),
       "line 2: <box>: only spheres can be read"},
      {link("<collision><geometry><sphere/></geometry></collision>"),
       "line 2: <sphere>: radius = '', must be a number"},
      {link("<collision><geometry><sphere radius='1 2'/></geometry></collision>"), "radius = '1 2', must be a number"},
      {link("<collision><geometry><sphere radius='nan'/></geometry></collision>"), "radius = 'nan', must be a number"},
      {link("<collision><geometry><sphere radius='0'/></geometry></collision>"), "radius = 0, must be from"},
      {link("<collision><geometry><sphere radius='-1'/></geometry></collision>"), "radius = -1, must be from"},
      {link("<collision><origin xyz='1 2'/><geometry><sphere radius='1'/></geometry></collision>"),
       "xyz = '1 2', must be three numbers"},
      {link("<collision><origin xyz='1 2 3 4'/><geometry><sphere radius='1'/></geometry></collision>"),
       "must be three numbers"},
      {link("<collision><origin xyz='1 2 1e10'/><geometry><sphere radius='1'/></geometry></collision>"),
       "coordinate = 10000000000"},
  };
  for (const auto& [text, rule] : cases) {
    const std::string message = refusal("a.urdf", text);
    EXPECT_NE(message.find(rule), std::string::npos) << text << " -> " << message;
    EXPECT_EQ(message.find(file("a.urdf").string() + ": "), 0U) << message;
  }
}

TEST_F(TreeFormats, EachBrokenYamlIsRefusedWithItsPlace) {
  const auto list = [](const std::string& inside) { return "collision_spheres:\n  a:\n" + inside; };
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "must have collision_spheres"},
      {"[1, 2]", "must have collision_spheres"},
      {"collision_spheres: spheres/arm.yml", "must have collision_spheres with a list of spheres for each link"},
      {"collision_spheres: {a: 3}", "no link has spheres"},
      {"collision_spheres: {[1]: []}", "no link has spheres"},
      {"a: [", "not valid YAML"},
      {list("  - 3\n"), "collision_spheres.a[0]: must be a sphere with center and radius"},
      {list("  - {center: [0, 0, 0]}\n"), "must be a sphere with center and radius"},
      {list("  - {radius: 1}\n"), "must be a sphere with center and radius"},
      {list("  - {center: [0, 0], radius: 1}\n"), "collision_spheres.a[0]: center must be a list of three numbers"},
      {list("  - {center: [0, 0, x], radius: 1}\n"), "center must be a list of three numbers"},
      {list("  - {center: [0, 0, .nan], radius: 1}\n"), "center must be a list of three numbers"},
      {list("  - {center: 3, radius: 1}\n"), "center must be a list of three numbers"},
      {list("  - {center: [0, 0, 0], radius: [1]}\n"), "collision_spheres.a[0]: radius must be a number"},
      {list("  - {center: [0, 0, 0], radius: 1}\n  - {center: [0, 0, 0], radius: -1}\n"),
       "collision_spheres.a[1]: radius = -1, must be from"},
      {list("  - {center: [0, 2e9, 0], radius: 1}\n"), "coordinate = 2000000000"},
  };
  const std::string alias = "; aliases are not followed, and line 1 has one: must be written out";
  const std::string sphere = "a: [&s {center: [0, 0, 0], radius: 1}, &c [0, 0, 0], *s]\n";
  for (const auto& [inside, rule] : std::vector<std::pair<std::string, std::string>>{
           {list("  - *s\n"), "collision_spheres.a[0]: must be a sphere with center and radius"},
           {list("  - {center: *c, radius: 1}\n"), "collision_spheres.a[0]: center must be a list of three numbers"},
           {list("  - {<<: *s, radius: 1}\n"), "collision_spheres.a[0]: must be a sphere with center and radius"},
           {"collision_spheres: {a: *c}\n", "no link has spheres"},
           {"collision_spheres: *s\n", "must have collision_spheres with a list of spheres for each link"}}) {
    const std::string message = refusal("a.yaml", sphere + inside);
    EXPECT_TRUE(message.ends_with(rule + alias)) << inside << " -> " << message;
  }
  for (const auto& [text, rule] : cases) {
    const std::string message = refusal("a.yaml", text);
    EXPECT_EQ(message.find("alias"), std::string::npos) << message;
    EXPECT_NE(message.find(rule), std::string::npos) << text << " -> " << message;
  }
  EXPECT_NE(refusal("a.yml", std::string(20000, '[')).find("not valid YAML"), std::string::npos) << "deep nesting";
  std::string flow = "{collision_spheres: {a: [";
  while (flow.size() < 500'000) flow += "{center: [0, 0, 0], radius: 1},";
  // Comments count too: the parser tells of nothing while it reads them.
  const std::string comments = "a: 1\n" + std::string(300'000, '#') + "\ncollision_spheres:\n";
  for (const std::string& text : {flow + "]}}", comments}) {
    const std::string message = refusal("a.yml", text);
    EXPECT_NE(message.find("more than 262144 bytes of one text, one collection in brackets or comments in a row, must"),
              std::string::npos)
        << message;
  }
}

TEST_F(TreeFormats, YamlOfOtherThingsBesideTheSpheresIsReadPast) {
  const std::string text =
      "%YAML 1.2\n---\nrobot_cfg:\n  common: &other {a: [1, 2, {b: c}]}\n  kinematics:\n    again: *other\n"
      "    names:\n      [\n        \"x: y\", # a comment [\n        'it''s',\n      ]\n    text: |\n      - {center: "
      "no}\n"
      "    ? [complex, key]\n    : 1\n    empty:\n    collision_spheres:\n      'base link':\n"
      "      - \"center\": [0.0, +1.0, -2e-1]\n        \"radius\": 0.5\n        tag: !!str 3\n";
  const auto path = file("robot.yml");
  std::ofstream(path) << text;
  const auto spheres = read_spheres(path);
  ASSERT_TRUE(spheres.ok()) << spheres.error().message;
  ASSERT_EQ(spheres.value().size(), 1U);
  EXPECT_EQ(spheres.value()[0].center_m, Vec3(0, 1, -0.2));
}

TEST_F(TreeFormats, EachBrokenFoamFileIsRefusedWithItsPlace) {
  const auto level = [](const std::string& inside) {
    return R"([{"mean":0,"best":0,"worst":0,"spheres":[)" + inside + "]}]";
  };
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "not valid JSON"},
      {"[1, 2", "line 1, column 6: not valid JSON: syntax error"},
      {"{}", "must be a list of levels"},
      {"[]", "must be a list of levels"},
      {"[3]", "[0]: must have a list of spheres"},
      {"[{}]", "[0]: must have a list of spheres"},
      {R"([{"spheres": 3}])", "[0]: must have a list of spheres"},
      {level(""), "has no spheres, at least one is needed"},
      {level("3"), "[0].spheres[0]: must be a sphere with origin and radius"},
      {level(R"({"radius": 1})"), "must be a sphere with origin and radius"},
      {level(R"({"origin": [0, 0], "radius": 1})"), "[0].spheres[0].origin: must be a list of three numbers"},
      {level(R"({"origin": [0, 0, "x"], "radius": 1})"), "must be a list of three numbers"},
      {level(R"({"origin": [0, 0, 0], "radius": "1"})"), "[0].spheres[0].radius: must be a number"},
      {level(R"({"origin": [0, 0, 0], "radius": 1}, {"origin": [0, 0, 0], "radius": 0})"),
       "[0].spheres[1]: radius = 0"},
      {level(R"({"origin": [0, 0, 1e400], "radius": 1})"), "[0].spheres[0].origin[2] = 1e400, cannot be represented"},
      {"\xff", "not valid JSON"},
  };
  for (const auto& [text, rule] : cases) {
    const std::string message = refusal("a.json", text);
    EXPECT_NE(message.find(rule), std::string::npos) << text << " -> " << message;
  }
  EXPECT_NE(refusal("a.json", level(R"({"origin": [0, 0, 0], "radius": 1})"), {.level = Level{1}})
                .find("has no level 1, the deepest is 0"),
            std::string::npos);
  EXPECT_NE(refusal("a.json", std::string(200000, '[')).find("nested deeper than 64 levels"), std::string::npos);
}

TEST_F(TreeFormats, AFoamFileOf100000MembersIsReadAsQuicklyAsItIsLong) {
  std::string text = R"([{"spheres": [{"origin": [0, 0, 0], "radius": 1}])";
  for (int i = 0; i < 100'000; ++i) text += fmt::format(", \"k{}\": 0", i);
  std::ofstream(file("many.json")) << text << "}]";
  const auto spheres = read_spheres(file("many.json"));
  ASSERT_TRUE(spheres.ok()) << spheres.error().message;
  EXPECT_EQ(spheres.value().size(), 1U);
}

TEST_F(TreeFormats, MoreSpheresThanAUnionMayHaveAreRefused) {
  std::string text = "collision_spheres:\n  a:\n";
  for (std::size_t i = 0; i <= kMaxUnionSpheres; ++i) text += "  - {center: [0, 0, 0], radius: 1}\n";
  EXPECT_NE(refusal("a.yml", text).find("one sphere too many, at most 32768"), std::string::npos);
}

TEST_F(TreeFormats, UnknownEndingsAndMissingFilesAreRefused) {
  EXPECT_NE(refusal("a.txt", "").find("must end in .sph"), std::string::npos);
  EXPECT_NE(read_spheres(file("missing.json")).error().message.find("no such file"), std::string::npos);
  EXPECT_NE(read_spheres(file("missing.sph")).error().message.find("no such file"), std::string::npos);
  ASSERT_TRUE(write_tree(small_tree(), 0, TreeFormat::Sph, "", file("a.sph")));
  EXPECT_NE(read_spheres(file("a.sph"), {.level = Level{5}}).error().message.find("has no level 5"), std::string::npos);
}

TEST(AdoptTree, ATreeThatCoversIsSoundAndGetsItsProtrusions) {
  const TriangleMesh mesh = test::box_mesh(Vec3(1, 2, 3));
  const SphereTree built = build_sphere_tree(mesh, {.depth = 1, .preset = TreePreset::Fast, .threads = 1}).value();
  SphereTree foreign = built;
  std::ranges::fill(foreign.protrusion_max_m, 0.0F);
  std::ranges::fill(foreign.fit, NodeFit{});
  const auto report = adopt_tree(foreign, mesh, {.samples = 2000, .threads = 2});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report.value().covers_surface());
  EXPECT_EQ(report.value().inside_coverage, 1);
  EXPECT_EQ(report.value().levels.size(), 2U);
  EXPECT_EQ(report.value().summary(), "surface covered to 100 %, inside to 100 %");
  EXPECT_EQ(foreign.protrusion_max_m, built.protrusion_max_m);
  EXPECT_GT(foreign.protrusion_max_m[0], 0);
  for (std::size_t i = 0; i < built.node_count(); ++i) EXPECT_EQ(foreign.fit[i].radius_m, built.fit[i].radius_m) << i;
  EXPECT_EQ(foreign.radius_m, built.radius_m);
}

TEST(AdoptTree, ALeakIsFoundAndSaidWithItsLevel) {
  const TriangleMesh mesh = test::box_mesh(Vec3(1, 2, 3));
  SphereTree tree = build_sphere_tree(mesh, {.depth = 1, .preset = TreePreset::Fast, .threads = 1}).value();
  tree.radius_m[3] *= 0.7F;
  const ForeignTreeReport report = adopt_tree(tree, mesh, {.samples = 2000, .threads = 1}).value();
  EXPECT_FALSE(report.covers_surface());
  EXPECT_EQ(report.levels[0].surface_coverage, 1);
  EXPECT_EQ(report.surface_coverage, report.levels[1].surface_coverage);
  EXPECT_NE(report.summary().find("% (level 1), inside"), std::string::npos) << report.summary();
}

TEST(AdoptTree, OneMissingPointInAMillionIsNotCalledWhole) {
  ForeignTreeReport report;
  report.levels.resize(1);
  report.surface_coverage = report.levels[0].surface_coverage = 1 - 1e-6;
  EXPECT_EQ(report.summary(), "surface covered to 99.99 % (level 0), inside to 100 %");
  EXPECT_FALSE(report.covers_surface());
}

TEST(AdoptTree, RefusesWhatTheJudgeRefuses) {
  SphereTree empty;
  EXPECT_FALSE(adopt_tree(empty, test::box_mesh(Vec3(1, 1, 1))));
  SphereTree ball = tree_of_spheres(std::vector<Sphere>{{Vec3::Zero(), 1}}).value();
  EXPECT_FALSE(adopt_tree(ball, test::box_mesh(Vec3(1, 1, 1)), {.samples = 0}));
}

}  // namespace
}  // namespace poise
