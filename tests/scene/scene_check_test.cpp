// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "scene/check/placed_bodies.h"
#include "scene/check/scene_check.h"
#include "scene/scene_text.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

io::SceneCheck check_of(const std::string& text, const std::filesystem::path& base = "/nowhere") {
  const Result<Scene> scene = parse_scene(text, "s.json", base);
  EXPECT_TRUE(scene) << scene.error().message;
  return scene ? io::check_scene(scene.value(), {}) : io::SceneCheck{};
}

/// The warnings of a scene, as one text.
std::string warnings_of(const std::string& text, const std::filesystem::path& base = "/nowhere") {
  const io::SceneCheck check = check_of(text, base);
  EXPECT_TRUE(check.errors.empty()) << check.errors.front();
  std::string all;
  for (const std::string& warning : check.warnings) all += warning + "\n";
  return all;
}

constexpr const char* kGravity = R"("gravity_mps2": [0, 0, -9.81], )";

std::string bodies_at(const std::vector<std::string>& ball_members) {
  std::string bodies = R"([{"shape": "floor", "material": "hard", "static": true})";
  for (const std::string& members : ball_members)
    bodies += R"(, {"shape": "ball", "material": "hard", )" + members + "}";
  return bodies + "]";
}

TEST(SceneCheck, FindsNothingWrongWithASoundScene) {
  const io::SceneCheck check = check_of(scene_text(kGravity, bodies_at({R"("position_m": [0, 0, 0.5])"})));
  EXPECT_TRUE(check.errors.empty());
  EXPECT_TRUE(check.warnings.empty()) << check.warnings.front();
  EXPECT_EQ(check.bodies, 2U);
  EXPECT_EQ(check.dynamic_bodies, 1U);
  EXPECT_EQ(check.trees_to_build, 0U);
  EXPECT_GT(check.memory_bytes, 1e6);
  EXPECT_EQ(check.deadline_ms, 10);
}

/// The error of a scene that a run refuses too, with the same words.
std::string error_of(const std::string& text) {
  const io::SceneCheck check = check_of(text);
  EXPECT_EQ(check.errors.size(), 1U) << text;
  const Result<Scene> scene = parse_scene(text, "s.json", "/nowhere");
  const Result<SceneRun> run = SceneRun::create(scene.value(), serial());
  EXPECT_FALSE(run) << text;
  if (run || check.errors.empty()) return {};
  EXPECT_EQ(check.errors.front(), run.error().message);
  return check.errors.front();
}

TEST(SceneCheck, RefusesWhatARunRefuses) {
  EXPECT_EQ(
      error_of(scene_text("", bodies_at({R"("position_m": [0, 0, 0.5], "inertia_kgm2": [1e-30, 1, 1])"}))),
      "s.json: bodies[1]: inertia_kgm2 = [1e-30, 1, 1], each must be >= 1.3089969389957472e-10 (the mass times the "
      "square of the bounding radius, times 1e-12)");
  const std::string tiny = R"({"name": "t", "dt_s": 0.01, "materials": {"m": {"density_kgpm3": 1e-9}},
    "shapes": {"ball": {"sphere": {"radius_m": 1e-4}}}, )";
  const std::string rule = "mass from density and volume, mass_kg = 4.188790204786391e-21, must be in [1e-18, 1e+18]";
  EXPECT_EQ(error_of(tiny + R"("bodies": [{"shape": "ball", "material": "m"}]})"), "s.json: bodies[0]: " + rule);
  EXPECT_EQ(error_of(tiny + R"("generators": [{"grid": {"shapes": ["ball"], "material": "m", "spacing_m": 1,
                                "count": [1, 1, 2]}}]})"),
            "s.json: generators: " + rule);
}

TEST(SceneCheck, WarnsWhereSpheresOfAWideThinMeshAreCoarserThanWhatLiesOnIt) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("box.obj"))
      << "v 0 0 0\nv 8 0 0\nv 0 8 0\nv 8 8 0\nv 0 0 0.02\nv 8 0 0.02\nv 0 8 0.02\nv 8 8 0.02\n"
         "f 1 3 2\nf 2 3 4\nf 5 6 7\nf 6 8 7\nf 1 2 5\nf 2 6 5\nf 3 7 4\nf 4 7 8\nf 1 5 3\nf 3 5 7\nf 2 4 6\nf 4 8 6\n";
  const auto with = [&](const std::string& members, const std::string& ball_m) {
    return R"({"name": "f", "dt_s": 0.01, )" + members + R"("materials": {"m": {}},
      "shapes": {"plate": {"mesh": {"file": "box.obj", "depth": 1}},
                 "ball": {"sphere": {"radius_m": )" +
           ball_m + R"(}}},
      "bodies": [{"shape": "plate", "material": "m", "static": true},
                 {"shape": "ball", "material": "m", "position_m": [4, 4, 9]}]})";
  };
  io::SceneCheckOptions options;
  options.tree_cache = TreeCacheSettings{.folder = folder.path() / "cache"};
  const auto warnings = [&](const std::string& text) {
    const Result<Scene> scene = parse_scene(text, "s.json", folder.path());
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
    SceneRunOptions run = serial();
    run.tree_cache = options.tree_cache;
    EXPECT_TRUE(SceneRun::create(scene.value(), run));
    const io::SceneCheck check = io::check_scene(scene.value(), options);
    return check.warnings.empty() ? std::string() : check.warnings.front();
  };
  EXPECT_EQ(warnings(with("", "0.1")).substr(0, 37), "s.json: shapes.plate: its spheres are");
  EXPECT_EQ(warnings(with("", "5")).find("spheres"), std::string::npos);
  EXPECT_EQ(warnings(with(R"("max_level": "polygons", )", "0.1")).find("spheres"), std::string::npos);
}

TEST(SceneCheck, FindsNothingWrongWithTheScenesThatShip) {
  for (const auto& entry : std::filesystem::directory_iterator(POISE_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".json") continue;
    const Result<Scene> scene = read_scene(entry.path());
    ASSERT_TRUE(scene);
    const io::SceneCheck check = io::check_scene(scene.value(), {});
    // real-meshes names files that are not shipped and must be downloaded.
    if (entry.path().stem() == "real-meshes") continue;
    EXPECT_TRUE(check.errors.empty()) << check.errors.front();
    for (const std::string& warning : check.warnings) EXPECT_EQ(warning.find("bodies["), std::string::npos) << warning;
  }
}

TEST(SceneCheck, TellsBodiesBelowTheFloorAndInOneAnother) {
  EXPECT_NE(warnings_of(scene_text(kGravity, bodies_at({R"("position_m": [0, 0, -1])"})))
                .find("s.json: bodies: below a floor or in a wall at the start: a body, first bodies[1] (ball) and "
                      "bodies[0] (floor), 1.5 m deep"),
            std::string::npos);
  EXPECT_NE(warnings_of(scene_text(kGravity, bodies_at({R"("position_m": [0, 0, 0.4])"}))).find("below a floor"),
            std::string::npos);
  EXPECT_EQ(warnings_of(scene_text(kGravity, bodies_at({R"("position_m": [0, 0, 0.46])"}))), "");
  const auto two = [](const std::string& x, const std::string& more) {
    return warnings_of(
        scene_text(kGravity, bodies_at({R"("position_m": [0, 0, 2])", R"("position_m": [)" + x + ", 0, 2]" + more})));
  };
  EXPECT_NE(
      two("0.5", "").find("start deep in one another: a pair, first bodies[1] (ball) and bodies[2] (ball), 0.5 m"),
      std::string::npos);
  EXPECT_EQ(two("0.96", ""), "");
  EXPECT_EQ(two("0.5", R"(, "collides_with": 2)"), "") << "they never meet";
}

TEST(SceneCheck, TellsWhatDoesNotFitItsTray) {
  const auto tray = [](const std::string& top, const std::string& side) {
    return warnings_of(scene_text(top + R"("tray": {"material": "hard", "side_m": )" + side + "}, ",
                                  R"([{"shape": "ball", "material": "hard", "position_m": [0, 0, 3]}])"));
  };
  EXPECT_NE(tray(kGravity, "0.9").find("s.json: shapes.ball: is 1 m long, larger than the tray, whose side is 0.9 m"),
            std::string::npos);
  EXPECT_EQ(tray(kGravity, "2"), "");
  EXPECT_NE(tray("", "2").find("gravity_mps2: is zero, and the scene has a tray"), std::string::npos);
  EXPECT_NE(tray(R"("gravity_mps2": [0, 0, 3], )", "2").find("does not point down"), std::string::npos);
}

TEST(SceneCheck, TellsATrayThatIsTooWide) {
  const io::SceneCheck check = check_of(scene_text(
      R"("tray": {"material": "hard", "side_per_sqrt_body_m": 1e9}, "generators": [{"grid": {"count": [3, 3, 3],
         "spacing_m": 2, "shapes": ["ball"], "material": "hard"}}], )",
      R"([{"shape": "ball", "material": "hard", "position_m": [0, 0, 3]}])"));
  ASSERT_EQ(check.errors.size(), 1U);
  EXPECT_EQ(check.errors[0].rfind("s.json: tray: a side of 5.19615e+09 m: offset_m = -2598076211", 0), 0U)
      << check.errors[0];
}

TEST(SceneCheck, TellsADeadlineThatCannotBeKept) {
  const std::string many = R"("generators": [{"grid": {"shape": "ball", "material": "hard", "spacing_m": 2,
    "count": [30, 30, 30], "origin_m": [0, 0, 9]}}], )";
  EXPECT_NE(
      warnings_of(scene_text(many + R"("deadline_ms": 1, )")).find("s.json: deadline_ms: a frame has 1 ms; 27001"),
      std::string::npos);
  EXPECT_EQ(warnings_of(scene_text(many + R"("deadline_ms": 1000, )")), "");
  EXPECT_NE(warnings_of(scene_text(R"("deadline_ms": 0.00001, "policy": {"front_growth": 64}, )")).find("deadline_ms"),
            std::string::npos);
}

TEST(SceneCheck, TellsACameraThatSeesNothing) {
  const auto seen = [](const std::string& look_at) {
    return warnings_of(scene_text(R"("camera": {"position_m": [0, -5, 1], "look_at_m": )" + look_at + "}, ",
                                  bodies_at({R"("position_m": [0, 0, 1])"})));
  };
  EXPECT_EQ(seen("[0, 0, 1]"), "");
  EXPECT_NE(seen("[0, -9, 1]").find("s.json: camera: sees none of the moving bodies at the start"), std::string::npos);
  EXPECT_NE(seen("[9, -5, 1]").find("camera"), std::string::npos);
}

TEST(SceneCheck, TellsATimeStepThatIsTooLong) {
  const auto step = [](const std::string& top, const std::string& speed) {
    return warnings_of(
        scene_text(top, bodies_at({R"("position_m": [0, 0, 3], "velocity_mps": [)" + speed + ", 0, 0]"})));
  };
  EXPECT_EQ(step("", "49"), "");
  EXPECT_NE(step("", "51").find("s.json: dt_s: too long for shapes.ball: at 51 m/s it moves 0.51 m in a step"),
            std::string::npos);
  EXPECT_EQ(step(R"("backtracking": true, )", "51"), "");
  EXPECT_NE(step(R"("gravity_mps2": [0, 0, -9810], )", "0").find("what falls gains 0.981 m a step"), std::string::npos);
}

TEST(SceneCheck, TellsAGltfMeshThatLiesOnItsBack) {
  const TemporaryFolder folder;
  // One triangle as a shell: positions in a data URI.
  std::ofstream(folder.file("m.gltf")) << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA",
                 "byteLength": 36}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
                   "max": [1, 1, 0]}]})";
  const auto with = [&](const std::string& members) {
    return warnings_of(std::string("{") + kGravity +
                           R"("name": "x", "dt_s": 0.01, "materials": {"m": {}},
                              "shapes": {"s": {"mesh": {"file": "m.gltf", "shell_thickness_m": 0.1)" +
                           members + R"(}}}, "bodies": [{"shape": "s", "material": "m"}]})",
                       folder.path());
  };
  EXPECT_NE(with("").find("s.json: shapes.s.mesh: glTF files have y upward, so it lies on its back"),
            std::string::npos);
  EXPECT_EQ(with(R"(, "up": "y")").find("its back"), std::string::npos);
  EXPECT_EQ(with(R"(, "up": "z")").find("its back"), std::string::npos);
}

TEST(SceneCheck, TellsEveryFileThatCannotBeUsed) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("bad.obj")) << "v 0 0 0\nf 1 2 3\n";
  const io::SceneCheck check = check_of(
      R"({"name": "x", "dt_s": 1, "materials": {"m": {}}, "shapes": {"a": {"mesh": {"file": "none.obj"}},
          "b": {"mesh": {"file": "bad.obj"}}, "c": {"tree": {"file": "none.sph"}}, "d": {"sphere": {"radius_m": 1}}},
          "bodies": [{"shape": "a", "material": "m"}]})",
      folder.path());
  ASSERT_EQ(check.errors.size(), 3U);
  EXPECT_EQ(check.errors[0].rfind("s.json: shapes.a.mesh: ", 0), 0U) << check.errors[0];
  EXPECT_EQ(check.errors[1].rfind("s.json: shapes.b.mesh: ", 0), 0U) << check.errors[1];
  EXPECT_EQ(check.errors[2].rfind("s.json: shapes.c.tree: ", 0), 0U) << check.errors[2];
}

TEST(SceneCheck, KnowsWhichTreesAreBuiltAlready) {
  const TemporaryFolder folder;
  const std::string text = std::string(R"({"name": "x", "dt_s": 1, "materials": {"m": {}}, "shapes": {"s": {"mesh":
    {"file": ")") + POISE_SOURCE_DIR +
                           R"(/scenes/meshes/slab.obj", "depth": 1}}},
    "bodies": [{"shape": "s", "material": "m"}]})";
  const Result<Scene> scene = parse_scene(text, "s.json", "/nowhere");
  ASSERT_TRUE(scene) << scene.error().message;
  io::SceneCheckOptions options;
  options.tree_cache.emplace();
  options.tree_cache->folder = folder.path();
  const io::SceneCheck before = io::check_scene(scene.value(), options);
  EXPECT_EQ(before.trees_to_build, 1U);
  EXPECT_GT(before.tree_cpu_s, 1);
  EXPECT_EQ(folder.entries(), 0U) << "a check builds nothing";
  SceneRunOptions run;
  run.tree_cache = options.tree_cache;
  std::vector<double> shares;
  run.tree_progress = [&](double share) { shares.push_back(share); };
  ASSERT_TRUE(SceneRun::create(scene.value(), run));
  ASSERT_FALSE(shares.empty());
  EXPECT_EQ(shares.back(), 1);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  const io::SceneCheck after = io::check_scene(scene.value(), options);
  EXPECT_EQ(after.trees_to_build, 0U);
  EXPECT_EQ(after.trees_ready, 1U);
}

TEST(SceneCheck, TheBoundReachesAsFarAsTheBody) {
  std::vector<Sphere> points;
  for (int i = 0; i < 4000; ++i) {
    const double turn = 0.1 * i, z = i / 2000.0 - 1;
    const double across = std::sqrt(1 - z * z);
    points.push_back({Vec3(across * std::cos(turn), across * std::sin(turn), z), 0});
  }
  const std::vector<Sphere> outline = io::outline_of(points);
  EXPECT_LE(outline.size(), 256U);
  double lowest = 0;
  for (const Sphere& part : outline) lowest = std::min(lowest, part.center_m.dot(Vec3(0.6, 0, 0.8)));
  EXPECT_LT(lowest, -0.98);
}

}  // namespace
}  // namespace poise::testing
