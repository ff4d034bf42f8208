// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "scene/scene_text.h"

namespace poise::testing {
namespace {

struct Case {
  std::string text;
  std::string message;  ///< after "s.json: "
};

void expect_refusals(const std::vector<Case>& cases) {
  for (const Case& c : cases) EXPECT_EQ(refusal(c.text), "s.json: " + c.message) << c.text;
}

Case top(const std::string& members, const std::string& message) { return {scene_text(members), message}; }
Case body(const std::string& members, const std::string& message) {
  return {scene_text(
              "", R"([{"shape": "floor", "material": "hard", "static": true}, {"shape": "ball", "material": "hard", )" +
                      members + "}]"),
          message};
}
Case shape(const std::string& source, const std::string& message) {
  return {R"({"name": "x", "dt_s": 1, "materials": {"m": {}}, "shapes": {"s": )" + source +
              R"(}, "bodies": [{"shape": "s", "material": "m"}]})",
          message};
}
Case generator(const std::string& text, const std::string& message) {
  return top("\"generators\": [" + text + "], ", message);
}
Case grid(const std::string& members, const std::string& message) {
  return generator(R"({"grid": {"shape": "ball", "material": "hard", )" + members + "}}", message);
}
Case stream(const std::string& members, const std::string& message) {
  return generator(R"({"stream": {"shape": "ball", "material": "hard", "region_min_m": [0, 0, 0], )" + members + "}}",
                   message);
}

TEST(SceneRefusals, NameTheFieldOfTheFrame) {
  expect_refusals({
      {"[]", "must be an object, is []"},
      {"3", "must be an object, is 3"},
      {"{}", "name: missing, and it is required"},
      {R"({"name": "x"})", "dt_s: missing, and it is required"},
      {R"({"name": "x", "dt_s": 1})", "materials: missing, and it is required"},
      {R"({"name": "x", "dt_s": 1, "materials": {"m": {}}})", "shapes: missing, and it is required"},
      {R"({"name": "x", "dt_s": 1, "materials": {}, "shapes": {}})",
       "materials = an object, must be an object with at least one material"},
      {R"({"name": "x", "dt_s": 1, "materials": {"m": {}}, "shapes": []})",
       "shapes = [], must be an object with at least one shape"},
      {R"({"name": "x", "dt_s": 1, "materials": {"m": {}}, "shapes": {"s": {"sphere": {"radius_m": 1}}}})",
       "bodies and generators are both empty or missing, at least one body or generator is required"},
      {R"({"name": "", "dt_s": 1})", "name = \"\", must not be empty"},
      {R"({"name": 7, "dt_s": 1})", "name = 7, must be a text"},
      top(R"("dt": 1, )", "dt: no such field; did you mean \"dt_s\"?"),
      top(R"("gravty_mps2": 1, )", "gravty_mps2: no such field; did you mean \"gravity_mps2\"?"),
      top(R"("zebra": 1, )", "zebra: no such field"),
      top(R"("frames": 0, )", "frames = 0, must be a whole number from 1 to 1000000"),
      top(R"("frames": -1, )", "frames = -1, must be a whole number from 1 to 1000000"),
      top(R"("frames": 2.5, )", "frames = 2.5, must be a whole number from 1 to 1000000"),
      top(R"("frames": 1e30, )", "frames = 1e30, must be a whole number from 1 to 1000000"),
      top(R"("frames": "many", )", "frames = \"many\", must be a whole number from 1 to 1000000"),
      top(R"("seed": -1, )", "seed = -1, must be a whole number from 0 to 18446744073709551615"),
      top(R"("seed": 18446744073709551616, )",
          "seed = 18446744073709551616, must be a whole number from 0 to 18446744073709551615"),
      top(R"("gravity_mps2": 9.81, )", "gravity_mps2 = 9.81, must be a list of 3 numbers"),
      top(R"("gravity_mps2": [0, 0], )", "gravity_mps2 = [0, 0], must be a list of 3 numbers"),
      top(R"("gravity_mps2": [0, 0, 1e10], )", "gravity_mps2[2] = 1e10, must be <= 1e+09"),
      top(R"("gravity_mps2": [0, 0, 1e400], )", "gravity_mps2[2] = 1e400, cannot be represented as a double (line 1)"),
      top(R"("deadline_ms": 0, )", "deadline_ms = 0, must be > 0"),
      top(R"("alpha": 0.6, )", "alpha = 0.6, must be <= 0.5"),
      top(R"("alpha": 0, )", "alpha = 0, must be >= 1e-05"),
      top(R"("host_work": 3, )", "host_work = 3, must be an object"),
      top(R"("host_work": {"load": 3}, )", "host_work.load: no such field; did you mean \"load_ms\"?"),
      top(R"("host_work": {"load_ms": -1}, )", "host_work.load_ms = -1, must be >= 0"),
      top(R"("host_work": {"load_ms": 1, "jitter_ms": 2}, )", "host_work.jitter_ms = 2, must be at most load_ms"),
      top(R"("max_level": 7, )", "max_level = 7, must be a whole number from 0 to 6"),
      top(R"("max_level": "leaves", )", "max_level = \"leaves\", must be a whole number from 0 to 6, or \"polygons\""),
      {R"({"name": "x", "dt_s": 0})", "dt_s = 0, must be > 0"},
      {R"({"name": "x", "dt_s": -0.1})", "dt_s = -0.1, must be > 0"},
      {R"({"name": "x", "dt_s": 2})", "dt_s = 2, must be <= 1"},
      {R"({"name": "x", "dt_s": null})", "dt_s = null, must be a number"},
      {R"({"name": "x", "dt_s": 1, "dt_s": 2})", "dt_s is given twice"},
      top(R"("policy": {"kind": "best"}, )",
          "policy.kind = \"best\", must be perceptual, fifo, random, round-robin, size, deepest or equal-levels"),
      top(R"("policy": {"size": -1}, )", "policy.size = -1, must be >= 0"),
      top(R"("camera": {"position_m": [0, 0, 0]}, )", "camera.look_at_m: missing, and it is required"),
      top(R"("camera": {"position_m": [1, 1, 1], "look_at_m": [1, 1, 1]}, )",
          "camera.look_at_m: must differ from camera.position_m"),
      top(R"("camera": {"position_m": [0, 0, 0], "look_at_m": [0, 0, 1]}, )",
          "camera.up: must not be zero, nor along the line of sight"),
      top(R"("camera": {"position_m": [0, 0, 0], "look_at_m": [1, 0, 0], "vertical_fov_deg": 180}, )",
          "camera.vertical_fov_deg = 180, must be <= 179"),
      top(R"("camera": {"position_m": [0, 0, 0], "look_at_m": [1, 0, 0], "resolution_px": [0, 720]}, )",
          "camera.resolution_px[0] = 0, must be >= 1"),
      top(R"("gaze_px": [1, 1], )", "gaze_px = [1, 1], needs a camera"),
      top(R"("camera": {"position_m": [0, 0, 0], "look_at_m": [1, 0, 0], "loop": true}, )",
          "camera.loop = true, needs a path"),
      top(R"("camera": {"position_m": [0, 0, 0], "look_at_m": [1, 0, 0]}, "gaze_px": [1281, 0], )",
          "gaze_px = [1281, 0], must lie in the image of 1280 x 720 pixels"),
      top(R"("bodies": 3, )", "bodies is given twice"),
  });
}

Case camera_path(const std::string& keys, const std::string& message, const std::string& more = "") {
  return top("\"camera\": {\"path\": " + keys + more + "}, ", message);
}

TEST(SceneRefusals, NameTheKeyOfACameraPath) {
  const std::string key = R"({"time_s": 1, "position_m": [0, 0, 0], "look_at_m": [1, 0, 0]})";
  const auto second = [&key](const std::string& members) { return "[" + key + ", {" + members + "}]"; };
  expect_refusals({
      camera_path("3", "camera.path = 3, must be a list of at least two keys"),
      camera_path("[]", "camera.path = [], must be a list of at least two keys"),
      camera_path("[" + key + "]", "camera.path = [...], must be a list of at least two keys"),
      camera_path("[" + key + ", 7]", "camera.path[1] = 7, must be an object"),
      camera_path(second(R"("position_m": [0, 0, 0], "look_at_m": [1, 0, 0])"),
                  "camera.path[1].time_s: missing, and it is required"),
      camera_path(second(R"("time_s": 2, "look_at_m": [1, 0, 0])"),
                  "camera.path[1].position_m: missing, and it is required"),
      camera_path(second(R"("time_s": 2, "position_m": [1, 0, 0])"),
                  "camera.path[1].look_at_m: missing, and it is required"),
      camera_path(second(R"("time_s": 1, "position_m": [0, 0, 0], "look_at_m": [1, 0, 0])"),
                  "camera.path[1].time_s = 1, must be > that of the key before"),
      camera_path(second(R"("time_s": 0.5, "position_m": [0, 0, 0], "look_at_m": [1, 0, 0])"),
                  "camera.path[1].time_s = 0.5, must be > that of the key before"),
      camera_path(second(R"("time_s": -1, "position_m": [0, 0, 0], "look_at_m": [1, 0, 0])"),
                  "camera.path[1].time_s = -1, must be >= 0"),
      camera_path(second(R"("time_s": 1e400, "position_m": [0, 0, 0], "look_at_m": [1, 0, 0])"),
                  "camera.path[1].time_s = 1e400, cannot be represented as a double (line 1)"),
      camera_path(second(R"("time_s": 2, "position_m": [0, 0, 1e400], "look_at_m": [1, 0, 0])"),
                  "camera.path[1].position_m[2] = 1e400, cannot be represented as a double (line 1)"),
      camera_path(second(R"("time_s": 2, "position_m": [1, 0, 0], "look_at_m": [1, 0, 0])"),
                  "camera.path[1].look_at_m: must differ from camera.path[1].position_m"),
      camera_path(second(R"("time_s": 2, "position_m": [1, 0, 0], "look_at_m": [1, 0, 9])"),
                  "camera.up: must not be zero, nor along the line of sight of camera.path[1]"),
      camera_path(second(R"("time_s": 2, "position_m": [1, 0, 0], "look_at_m": [2, 0, 9], "vertical_fov_deg": 0)"),
                  "camera.path[1].vertical_fov_deg = 0, must be > 0"),
      camera_path(second(R"("time": 2)"), "camera.path[1].time: no such field; did you mean \"time_s\"?"),
      camera_path("[" + key + "]", "camera.position_m: not with path, whose keys have it",
                  R"(, "position_m": [0, 0, 0])"),
      camera_path("[" + key + "]", "camera.look_at_m: not with path, whose keys have it",
                  R"(, "look_at_m": [0, 0, 0])"),
      camera_path(second(R"("time_s": 2, "position_m": [0, 0, 5], "look_at_m": [1, 0, 0])"),
                  "camera.path[1].position_m: must be that of the first key, since the path is a loop",
                  R"(, "loop": true)"),
      camera_path(second(R"("time_s": 2, "position_m": [0, 0, 0], "look_at_m": [1, 1, 0])"),
                  "camera.path[1].look_at_m: must be that of the first key, since the path is a loop",
                  R"(, "loop": true)"),
      camera_path(second(R"("time_s": 2, "position_m": [0, 0, 0], "look_at_m": [1, 0, 0], "vertical_fov_deg": 20)"),
                  "camera.path[1].vertical_fov_deg: must be that of the first key, since the path is a loop",
                  R"(, "loop": true)"),
      camera_path(second(R"("time_s": 2, "position_m": [0, 0, 0], "look_at_m": [1, 0, 0])"),
                  "camera.loop = 1, must be true or false", R"(, "loop": 1)"),
  });
}

TEST(SceneRefusals, NameTheFieldOfABody) {
  expect_refusals({
      {scene_text("", "3"), "bodies = 3, must be a list"},
      {scene_text("", "[7]"), "bodies[0] = 7, must be an object"},
      {scene_text("", R"([{"material": "hard"}])"), "bodies[0].shape: missing, and it is required"},
      {scene_text("", R"([{"shape": "ball"}])"), "bodies[0].material: missing, and it is required"},
      {scene_text("", R"([{"shape": "bal", "material": "hard"}])"),
       "bodies[0].shape = \"bal\", must be the name of a shape; did you mean \"ball\"?"},
      {scene_text("", R"([{"shape": 3, "material": "hard"}])"), "bodies[0].shape = 3, must be the name of a shape"},
      {scene_text("", R"([{"shape": "ball", "material": "soft"}])"),
       "bodies[0].material = \"soft\", must be the name of a material"},
      {scene_text("", R"([{"shape": "floor", "material": "hard"}])"),
       "bodies[0].static: must be true, since the shape is a plane"},
      {scene_text("", R"([{"shape": "ball", "material": "hard", "static": true, "velocity_mps": [0, 0, 1]}])"),
       "bodies[0].velocity_mps = [0, 0, 1], must be zero for a static body"},
      {scene_text("",
                  R"([{"shape": "ball", "material": "hard", "static": true, "angular_velocity_radps": [0, 0, 1]}])"),
       "bodies[0].angular_velocity_radps = [0, 0, 1], must be zero for a static body"},
      body(R"("mass": 2)", "bodies[1].mass: no such field; did you mean \"mass_kg\"?"),
      body(R"("mass_kg": -1)", "bodies[1].mass_kg = -1, must be >= 1e-18"),
      body(R"("mass_kg": 0)", "bodies[1].mass_kg = 0, must be >= 1e-18"),
      body(R"("mass_kg": "2")", "bodies[1].mass_kg = \"2\", must be a number"),
      body(R"("mass_kg": 1e400)", "bodies[1].mass_kg = 1e400, cannot be represented as a double (line 2)"),
      body(R"("motion": "driven")", "bodies[1].motion = \"driven\", must be \"static\", \"kinematic\" or \"dynamic\""),
      body(R"("motion": 2)", "bodies[1].motion = 2, must be a text"),
      body(R"("static": true, "motion": "kinematic")", "bodies[1].motion = \"kinematic\", must agree with static"),
      body(R"("static": 1)", "bodies[1].static = 1, must be true or false"),
      body(R"("position_m": [0, 0, "a"])", "bodies[1].position_m[2] = \"a\", must be a number"),
      body(R"("position_m": [0, 0, 0, 0])", "bodies[1].position_m = [0, 0, 0, 0], must be a list of 3 numbers"),
      body(R"("orientation_wxyz": [0, 0, 0, 0])", "bodies[1].orientation_wxyz = [0, 0, 0, 0], must not be zero"),
      body(R"("orientation_wxyz": [1, 0, 0])",
           "bodies[1].orientation_wxyz = [1, 0, 0], must be a list of 4 numbers, w x y z"),
      body(R"("inertia_kgm2": [1, 1, 2.5])",
           "bodies[1].inertia_kgm2 = [1, 1, 2.5], must keep the triangle inequality: no moment larger than the other "
           "two together"),
      body(R"("inertia_kgm2": [1, 1, 0])", "bodies[1].inertia_kgm2[2] = 0, must be > 0"),
      body(R"("group": 4294967296)", "bodies[1].group = 4294967296, must be a whole number from 0 to 4294967295"),
      body(R"("importance": -0.5)", "bodies[1].importance = -0.5, must be >= 0"),
      body(R"("importance": 2e6)", "bodies[1].importance = 2e6, must be <= 1e+06"),
  });
}

TEST(SceneRefusals, NameTheFieldOfAMaterialOrAShape) {
  expect_refusals({
      {R"({"name": "x", "dt_s": 1, "materials": {"m": {"restitution": 1.5}}, "shapes": {}})",
       "materials.m.restitution = 1.5, must be <= 1"},
      {R"({"name": "x", "dt_s": 1, "materials": {"m": {"friction": -1}}, "shapes": {}})",
       "materials.m.friction = -1, must be >= 0"},
      {R"({"name": "x", "dt_s": 1, "materials": {"m": {"friction": 2e6}}, "shapes": {}})",
       "materials.m.friction = 2e6, must be <= 1e+06"},
      {R"({"name": "x", "dt_s": 1, "materials": {"odd name": {"density_kgpm3": 0}}, "shapes": {}})",
       "materials[\"odd name\"].density_kgpm3 = 0, must be >= 1e-09"},
      {R"({"name": "x", "dt_s": 1, "materials": {"m": {"density": 2}}, "shapes": {}})",
       "materials.m.density: no such field; did you mean \"density_kgpm3\"?"},
      shape("{}", "shapes.s: must have exactly one of sphere, plane, mesh, spheres, tree"),
      shape(R"({"sphere": {"radius_m": 1}, "plane": {"normal": [0, 0, 1]}})",
            "shapes.s: must have exactly one of sphere, plane, mesh, spheres, tree"),
      shape(R"({"ball": {"radius_m": 1}})", "shapes.s.ball: no such field"),
      shape(R"({"shpere": {"radius_m": 1}})", "shapes.s.shpere: no such field; did you mean \"sphere\"?"),
      shape(R"({"sphere": {}})", "shapes.s.sphere.radius_m: missing, and it is required"),
      shape(R"({"sphere": {"radius_m": 0}})", "shapes.s.sphere.radius_m = 0, must be >= 1e-09"),
      shape(R"({"sphere": {"radius_m": 1e10}})", "shapes.s.sphere.radius_m = 1e10, must be <= 1e+09"),
      shape(R"({"sphere": 1})", "shapes.s.sphere = 1, must be an object"),
      shape(R"({"plane": {"normal": [0, 0, 0]}})", "shapes.s.plane.normal = [0, 0, 0], must not be zero"),
      shape(R"({"plane": {"offset_m": 1}})", "shapes.s.plane.normal: missing, and it is required"),
      shape(R"({"mesh": {}})", "shapes.s.mesh.file: missing, and it is required"),
      shape(R"({"mesh": {"file": ""}})", "shapes.s.mesh.file = \"\", must be the name of a file"),
      shape(R"({"mesh": {"file": "a\u0000b"}})", "shapes.s.mesh.file = \"a?b\", must be the name of a file"),
      shape(R"({"mesh": {"file": "a.obj", "depth": 7}})",
            "shapes.s.mesh.depth = 7, must be a whole number from 0 to 6"),
      shape(R"({"mesh": {"file": "a.obj", "scale": 0}})", "shapes.s.mesh.scale = 0, must be > 0"),
      shape(R"({"mesh": {"file": "a.obj", "shell_thickness_m": 0}})",
            "shapes.s.mesh.shell_thickness_m = 0, must be >= 1e-09"),
      shape(R"({"mesh": {"file": "a.obj", "shell_thickness_m": "thin"}})",
            "shapes.s.mesh.shell_thickness_m = \"thin\", must be a number"),
      shape(R"({"tree": {"file": "a.sph", "scale": -1}})", "shapes.s.tree.scale = -1, must be > 0"),
      shape(R"({"tree": {"file": "a.sph", "mesh": ""}})", "shapes.s.tree.mesh = \"\", must be the name of a file"),
      shape(R"({"tree": {"file": "a.sph", "mesh": "a.obj", "allow_leaks": 1}})",
            "shapes.s.tree.allow_leaks = 1, must be true or false"),
      shape(R"({"tree": {"file": "a.sph", "allow_leaks": true}})",
            "shapes.s.tree.allow_leaks = true, needs a mesh beside it"),
      shape(R"({"tree": {"file": "a.sph", "shell_thickness_m": 1}})",
            "shapes.s.tree.shell_thickness_m = 1, needs a mesh beside it"),
      shape(R"({"spheres": {"centers_m": [], "radii_m": []}})",
            "shapes.s.spheres.centers_m = [], must be a list of at least one point"),
      shape(R"({"spheres": {"centers_m": [[0, 0, 0]], "radii_m": [1, 2]}})",
            "shapes.s.spheres.radii_m = [1, 2], must be a list of 1 numbers, one for each centre"),
      shape(R"({"spheres": {"centers_m": [[0, 0, 0]], "radii_m": [-1]}})",
            "shapes.s.spheres.radii_m[0] = -1, must be >= 1e-09"),
      shape(R"({"spheres": {"centers_m": [[0, 0]], "radii_m": [1]}})",
            "shapes.s.spheres.centers_m[0] = [0, 0], must be a list of 3 numbers"),
  });
}

TEST(SceneRefusals, NameTheFieldOfAGeneratorOrTheTray) {
  expect_refusals({
      top(R"("generators": {}, )", "generators = an object, must be a list"),
      generator("{}", "generators[0]: must have exactly one of grid, stream"),
      generator(R"({"grid": {"material": "hard"}})", "generators[0].grid: must have either shape or shapes"),
      generator(R"({"grid": {"shape": "floor", "material": "hard"}})",
                "generators[0].grid: shape \"floor\" is a plane, must be a solid"),
      generator(R"({"grid": {"shapes": ["ball", "cow"], "material": "hard"}})",
                "generators[0].grid.shapes[1] = \"cow\", must be the name of a shape"),
      grid(R"("count": [1, 1, 1])", "generators[0].grid.spacing_m: missing, and it is required"),
      grid(R"("spacing_m": 1)", "generators[0].grid.count: missing, and it is required"),
      grid(R"("spacing_m": 0, "count": [1, 1, 1])", "generators[0].grid.spacing_m = 0, must be > 0"),
      grid(R"("spacing_m": 1, "count": [1, 0, 1])",
           "generators[0].grid.count[1] = 0, must be a whole number from 1 to 10000000"),
      grid(R"("spacing_m": 1, "count": [1, 1])",
           "generators[0].grid.count = [1, 1], must be a list of 3 whole numbers"),
      grid(R"("spacing_m": 1, "count": [10000000, 10000000, 10000000])",
           "generators: make 10000001 bodies, the scene must have at most 10000000"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "mix": "any")",
           "generators[0].grid.mix = \"any\", must be cycle or seed"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "bodies": 3)",
           "generators[0].grid.bodies: only with in_tray; a free grid has count and origin_m"),
      grid(R"("spacing_m": 1, "in_tray": true, "bodies": 3)", "generators[0].grid.in_tray = true, needs a tray"),
      grid(R"("spacing_m": 1, "in_tray": true, "count": [1, 1, 1])",
           "generators[0].grid.count: not with in_tray, which has bodies and bottom_m"),
      grid(R"("spacing_m": 1, "in_tray": true, "blocks": {"count": [1, 1], "spacing_m": [1, 1]})",
           "generators[0].grid.blocks: not with in_tray, which has bodies and bottom_m"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "blocks": 3)", "generators[0].grid.blocks = 3, must be an object"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "blocks": {"spacing_m": [1, 1]})",
           "generators[0].grid.blocks.count: missing, and it is required"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "blocks": {"count": [2, 2]})",
           "generators[0].grid.blocks.spacing_m: missing, and it is required"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "blocks": {"count": [2, 2, 2], "spacing_m": [1, 1]})",
           "generators[0].grid.blocks.count = [2, 2, 2], must be a list of 2 whole numbers"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "blocks": {"count": [2, 0], "spacing_m": [1, 1]})",
           "generators[0].grid.blocks.count[1] = 0, must be a whole number from 1 to 10000000"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "blocks": {"count": [2, 2], "spacing_m": [1, -1]})",
           "generators[0].grid.blocks.spacing_m[1] = -1, must be > 0"),
      grid(R"("spacing_m": 1, "count": [10000, 1, 1], "blocks": {"count": [10000000, 10000000], "spacing_m": [1, 1]})",
           "generators: make 10000001 bodies, the scene must have at most 10000000"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "static": "yes")",
           "generators[0].grid.static = \"yes\", must be true or false"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "static": true, "velocity_mps": [0, 0, 1])",
           "generators[0].grid.velocity_mps = [0, 0, 1], must be zero for a static body"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "static": true, "speed_mps": 1)",
           "generators[0].grid.speed_mps = 1, must be zero for a static body"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "static": true, "spin_radps": 1)",
           "generators[0].grid.spin_radps = 1, must be zero for a static body"),
      grid(R"("spacing_m": 1, "count": [1, 1, 1], "life_s": 1)", "generators[0].grid.life_s: no such field"),
      stream(R"("per_second": 5, "to_s": 1, "region_max_m": [1, 1, 1], "life_s": 0)",
             "generators[0].stream.life_s = 0, must be > 0"),
      stream(R"("per_second": 5, "to_s": 1, "region_max_m": [1, 1, 1], "life_s": "long")",
             "generators[0].stream.life_s = \"long\", must be a number"),
      stream(R"("region_max_m": [1, 1, 1])", "generators[0].stream.per_second: missing, and it is required"),
      stream(R"("per_second": 5)", "generators[0].stream: must have either to_s or total"),
      stream(R"("per_second": 5, "to_s": 1, "total": 3)", "generators[0].stream: must have either to_s or total"),
      stream(R"("per_second": 5, "from_s": 2, "to_s": 1)", "generators[0].stream.to_s = 1, must be > from_s"),
      stream(R"("per_second": 1e8, "to_s": 1)", "generators[0].stream: makes 1e+08 bodies, must make 1 to 10000000"),
      stream(R"("per_second": 5, "to_s": 1)", "generators[0].stream.region_max_m: missing, and it is required"),
      stream(R"("per_second": 5, "to_s": 1, "region_max_m": [1, -1, 1])",
             "generators[0].stream.region_max_m = [1, -1, 1], must not be below region_min_m"),
      top(R"("tray": {"material": "hard"}, )", "tray: must have either side_m or side_per_sqrt_body_m"),
      top(R"("tray": {"material": "hard", "side_m": -1}, )", "tray.side_m = -1, must be > 0"),
      top(R"("tray": {"side_m": 1}, )", "tray.material: missing, and it is required"),
      top(R"("tray": {"material": "hard", "side_per_sqrt_body_m": 1}, "generators": [], )",
          "tray.side_per_sqrt_body_m: needs a generator"),
  });
}

TEST(SceneRefusals, OfTheFileItselfSayWhatIsWrongWithIt) {
  const auto message = [](const std::string& file) { return read_scene(file).error().message; };
  EXPECT_EQ(message("/nowhere/x.json"), "/nowhere/x.json: no such file");
  EXPECT_EQ(message("/tmp"), "/tmp: is a directory, must be a scene file");
  EXPECT_EQ(message("/dev/null"), "/dev/null: is a pipe or a device, must be a file; SCENE - reads the standard input");
  EXPECT_EQ(message("/dev/zero"), "/dev/zero: is a pipe or a device, must be a file; SCENE - reads the standard input");
  EXPECT_EQ(refusal("{\n\"name\": \"x\",\n}").substr(0, 40), "s.json: line 3, column 1: not valid JSON");
}

}  // namespace
}  // namespace poise::testing
