// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "poise/assets/mesh_file.h"
#include "poise/assets/sph_file.h"
#include "scene/scene_memory.h"
#include "scene/scene_shapes.h"
#include "scene/scene_text.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

TEST(SceneRun, PutsTheBodiesOfTheFileIntoTheWorld) {
  const Result<Scene> scene = parse(scene_text(R"("gravity_mps2": [0, 0, -10], )",
                                               R"([{"shape": "floor", "material": "hard", "static": true},
          {"shape": "ball", "material": "hard", "position_m": [1, 2, 3], "orientation_wxyz": [0, 0, 0, 2], "velocity_mps": [4, 5, 6],
           "angular_velocity_radps": [0, 0, 7]},
          {"shape": "ball", "material": "hard", "position_m": [9, 9, 9], "mass_kg": 3}])"));
  ASSERT_TRUE(scene) << scene.error().message;
  SceneRun run = run_of(scene.value());
  ASSERT_EQ(run.bodies().size(), 3U);
  EXPECT_EQ(run.bodies()[0].motion, MotionType::Static);
  const World& world = run.world();
  const BodyState ball = world.state(run.bodies()[1].id).value();
  EXPECT_EQ(ball.position_m, Vec3(1, 2, 3));
  EXPECT_EQ(ball.orientation.z(), 1);
  EXPECT_EQ(ball.velocity_mps, Vec3(4, 5, 6));
  EXPECT_EQ(ball.angular_velocity_radps, Vec3(0, 0, 7));
  EXPECT_NEAR(world.mass_kg(run.bodies()[1].id).value(), 1000 * 4.0 / 3 * M_PI * 0.125, 1e-9);
  EXPECT_EQ(world.mass_kg(run.bodies()[2].id).value(), 3);
  EXPECT_EQ(world.mass_kg(run.bodies()[0].id).value(), 0);
  // Gravity: the potential is m g z.
  const double m1 = world.mass_kg(run.bodies()[1].id).value();
  EXPECT_NEAR(world.conserved().potential_j, 10 * (3 * m1 + 9 * 3), 1e-6);
}

TEST(SceneRun, PlacesASingleBodyByItsOriginAndAGeneratedOneByItsCentreOfMass) {
  const Result<Scene> scene = parse(R"({"name": "x", "dt_s": 0.01, "materials": {"m": {}},
    "shapes": {"two": {"spheres": {"centers_m": [[1, 0, 0], [3, 0, 0]], "radii_m": [0.5, 0.5]}}},
    "bodies": [{"shape": "two", "material": "m", "position_m": [10, 0, 0], "orientation_wxyz": [0, 0, 0, 1]}],
    "generators": [{"grid": {"shape": "two", "material": "m", "count": [1, 1, 1], "spacing_m": 1, "origin_m": [0, 0, 50], "random_orientation": true}}]})");
  ASSERT_TRUE(scene) << scene.error().message;
  SceneRun run = run_of(scene.value());
  EXPECT_NEAR((run.shapes()[0]->origin_offset_m - Vec3(2, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((run.world().state(run.bodies()[0].id).value().position_m - Vec3(8, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((run.world().state(run.bodies()[1].id).value().position_m - Vec3(0, 0, 50)).norm(), 0, 1e-12);
}

TEST(SceneRun, KeepsSceneOrderWithTheTrayBetweenBodiesAndGrids) {
  const Result<Scene> scene = parse(scene_text(
      R"("tray": {"material": "hard", "side_m": 8}, "generators": [{"grid": {"shape": "ball", "material": "hard", "in_tray": true, "bodies": 5, "spacing_m": 2}}], )",
      R"([{"shape": "ball", "material": "hard", "position_m": [0, 0, 20]}])"));
  ASSERT_TRUE(scene) << scene.error().message;
  SceneRun run = run_of(scene.value());
  ASSERT_EQ(run.bodies().size(), 11U);
  for (std::size_t i = 0; i < 11; ++i) EXPECT_EQ(run.bodies()[i].motion == MotionType::Static, i >= 1 && i <= 5) << i;
  EXPECT_EQ(run.tray_side_m(), 8);
  const Vec3 normals[] = {{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  for (std::size_t i = 0; i < 5; ++i) {
    const ShapePtr plane = run.world().shape(run.bodies()[i + 1].id).value();
    EXPECT_EQ(plane->plane_normal, normals[i]);
    EXPECT_EQ(plane->plane_offset_m, i == 0 ? 0 : -4);
  }
}

TEST(SceneRun, AddsStreamBodiesInTheFrameTheyAreDueIn) {
  const Result<Scene> scene = parse(scene_text(
      R"("generators": [{"stream": {"shape": "ball", "material": "hard", "per_second": 50, "from_s": 0.01, "total": 3, "region_min_m": [5, 5, 5], "region_max_m": [9, 9, 9]}}], )"));
  ASSERT_TRUE(scene) << scene.error().message;
  SceneRun run = run_of(scene.value());
  const std::size_t expected[] = {1, 2, 2, 3, 3, 4, 4};  // due at 0.01, 0.03 and 0.05 s; a frame is 0.01 s
  for (std::uint64_t frame = 0; frame < 7; ++frame) {
    ASSERT_TRUE(run.before_frame(frame));
    EXPECT_EQ(run.bodies().size(), expected[frame]) << frame;
    EXPECT_EQ(run.final_body_count(), 4U);
  }
}

TEST(SceneRun, GivesTheSameHashForTheSameSeedAndAnotherForAnother) {
  const Result<Scene> scene = parse(scene_text(
      R"("generators": [{"grid": {"shape": "ball", "material": "hard", "count": [3, 3, 3], "spacing_m": 2, "jitter_m": 0.1, "origin_m": [3, 3, 3]}}], )"));
  ASSERT_TRUE(scene) << scene.error().message;
  SceneRunOptions other = serial();
  other.seed = 99;
  const std::uint64_t hash = run_of(scene.value()).world().state_hash();
  EXPECT_EQ(run_of(scene.value()).world().state_hash(), hash);
  EXPECT_NE(run_of(scene.value(), other).world().state_hash(), hash);
}

TEST(SceneRun, RefusesFilesThatAreMissingOrWrongWithSceneAndField) {
  const TemporaryFolder folder;
  const auto refusal_of = [&folder](const std::string& source) {
    const std::string text = R"({"name": "x", "dt_s": 1, "materials": {"m": {}}, "shapes": {"s": )" + source +
                             R"(}, "bodies": [{"shape": "s", "material": "m"}]})";
    const Result<Scene> scene = parse_scene(text, "s.json", folder.path());
    EXPECT_TRUE(scene) << scene.error().message;
    const Result<SceneRun> run = SceneRun::create(scene.value(), serial());
    return run ? std::string("accepted") : run.error().message;
  };
  const std::string missing = refusal_of(R"({"mesh": {"file": "no.obj"}})");
  EXPECT_EQ(missing.rfind("s.json: shapes.s.mesh: ", 0), 0U) << missing;
  EXPECT_NE(missing.find(folder.file("no.obj")), std::string::npos) << missing;
  EXPECT_EQ(refusal_of(R"({"tree": {"file": "no.sph"}})").rfind("s.json: shapes.s.tree: ", 0), 0U);
  std::ofstream(folder.file("open.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string open = refusal_of(R"({"mesh": {"file": "open.obj"}})");
  EXPECT_NE(open.find("3 edges with one triangle alone"), std::string::npos) << open;
  EXPECT_NE(open.find("a shell_thickness_m > 0 would make it a shell"), std::string::npos) << open;
}

TEST(SceneRun, UsesOpenMeshesWithAWarningAndSheetsAsShells) {
  const TemporaryFolder folder;
  // A box without its top, and a triangle of half a square metre.
  std::ofstream(folder.file("box.obj")) << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                                           "f 4 3 2 1\nf 1 2 6 5\nf 4 8 7 3\nf 2 3 7 6\nf 1 5 8 4\n";
  std::ofstream(folder.file("sheet.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const Result<Scene> scene = parse_scene(
      R"({"name": "x", "dt_s": 0.01, "materials": {"m": {"density_kgpm3": 1000}},
          "shapes": {"ball": {"sphere": {"radius_m": 1}}, "box": {"mesh": {"file": "box.obj", "depth": 0}},
                     "sheet": {"mesh": {"file": "sheet.obj", "depth": 0, "shell_thickness_m": 0.002}}},
          "bodies": [{"shape": "sheet", "material": "m"}, {"shape": "box", "material": "m", "position_m": [5, 0, 0]}]})",
      "s.json", folder.path());
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(std::get<MeshSource>(scene.value().shapes[2].source).shell_thickness_m, 0.002);
  SceneRun run = run_of(scene.value());
  ASSERT_EQ(run.warnings().size(), 1U);
  EXPECT_EQ(run.warnings()[0].rfind("s.json: shapes.box.mesh: open: 4 edges", 0), 0U) << run.warnings()[0];
  EXPECT_NEAR(run.world().mass_kg(run.bodies()[0].id).value(), 1, 1e-12);
  EXPECT_GT(run.world().mass_kg(run.bodies()[1].id).value(), 700);
  EXPECT_LT(run.world().mass_kg(run.bodies()[1].id).value(), 1100);
  StepInput step;
  step.dt_s = 0.01;
  EXPECT_EQ(run.world().step(step).status, StepStatus::Done);
}

/// A box of 1 x 2 x 3 m in box.obj, and its tree in box.sph.
void write_box(const TemporaryFolder& folder) {
  std::ofstream(folder.file("box.obj")) << "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nv 1 0 3\nv 1 2 3\nv 0 2 3\n"
                                           "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 2 3 7 6\nf 1 5 8 4\n";
  const TriangleMesh mesh = read_mesh(folder.file("box.obj"), {}).value();
  ASSERT_TRUE(write_sph(build_sphere_tree(mesh, {.depth = 1, .preset = TreePreset::Fast, .threads = 1}).value(),
                        folder.file("box.sph")));
}

Result<SceneRun> run_with_shape(const TemporaryFolder& folder, const std::string& shape,
                                const SceneRunOptions& options = serial()) {
  const Result<Scene> scene =
      parse_scene(R"({"name": "x", "dt_s": 0.01, "materials": {"m": {"density_kgpm3": 1000}}, "shapes": {"a": )" +
                      shape + R"(}, "bodies": [{"shape": "a", "material": "m"}]})",
                  "s.json", folder.path());
  if (!scene) return scene.error();
  return SceneRun::create(scene.value(), options);
}

TEST(SceneRun, ATreeWithItsMeshHasTheMassOfTheMesh) {
  const TemporaryFolder folder;
  write_box(folder);
  const Result<SceneRun> run =
      run_with_shape(folder, R"({"tree": {"file": "box.sph", "mesh": "box.obj", "scale": 0.1}})");
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_NEAR(run.value().world().mass_kg(run.value().bodies()[0].id).value(), 6, 1e-9);
  EXPECT_NEAR((run.value().shapes()[0]->origin_offset_m - Vec3(0.05, 0.1, 0.15)).norm(), 0, 1e-12);
  EXPECT_TRUE(run.value().warnings().empty());
  const SphereTree& tree = run.value().shapes()[0]->tree;
  for (std::size_t i = 0; i < tree.node_count(); ++i) EXPECT_GT(tree.protrusion_max_m[i], 0) << "measured on load";
}

TEST(SceneRun, ATreeThatLeaksIsRefusedUnlessTheSceneAllowsIt) {
  const TemporaryFolder folder;
  write_box(folder);
  SphereTree tree = read_sph(folder.file("box.sph")).value();
  tree.radius_m[2] *= 0.6F;
  ASSERT_TRUE(write_sph(tree, folder.file("leaks.sph")));
  const Result<SceneRun> refused = run_with_shape(folder, R"({"tree": {"file": "leaks.sph", "mesh": "box.obj"}})");
  ASSERT_FALSE(refused);
  const std::string& message = refused.error().message;
  EXPECT_EQ(message.find("s.json: shapes.a.tree: leaks.sph on box.obj: surface covered to 9"), 0U) << message;
  EXPECT_NE(message.find("(level 1)"), std::string::npos) << message;
  EXPECT_NE(message.find("\"allow_leaks\": true uses it all the same"), std::string::npos) << message;
  const Result<SceneRun> allowed =
      run_with_shape(folder, R"({"tree": {"file": "leaks.sph", "mesh": "box.obj", "allow_leaks": true}})");
  ASSERT_TRUE(allowed) << allowed.error().message;
  ASSERT_EQ(allowed.value().warnings().size(), 1U);
  EXPECT_EQ(allowed.value().warnings()[0].find("s.json: shapes.a.tree: leaks.sph on box.obj: surface covered to 9"),
            0U);
}

TEST(SceneRun, KeepsTreesWhereItIsToldAndSaysWhatBecameOfThem) {
  const TemporaryFolder folder;
  write_box(folder);
  const std::string shape = R"({"mesh": {"file": "box.obj", "depth": 0}})";
  const TemporaryFolder cache;
  SceneRunOptions options = serial();
  const Result<SceneRun> off = run_with_shape(folder, shape, options);
  EXPECT_EQ(off.value().tree_cache_use().off, 1U);
  EXPECT_EQ(cache.entries(), 0U);
  options.tree_cache = TreeCacheSettings{.folder = cache.path()};
  const Result<SceneRun> cold = run_with_shape(folder, shape, options);
  EXPECT_EQ(cold.value().tree_cache_use().built, 1U);
  const Result<SceneRun> warm = run_with_shape(folder, shape, options);
  EXPECT_EQ(warm.value().tree_cache_use().hits, 1U);
  EXPECT_EQ(cache.entries(), 1U);
  const Result<SceneRun> shell =
      run_with_shape(folder, R"({"mesh": {"file": "box.obj", "depth": 0, "shell_thickness_m": 0.01}})", options);
  ASSERT_TRUE(shell) << shell.error().message;
  EXPECT_EQ(shell.value().tree_cache_use().built, 1U) << "a shell is another tree";
  EXPECT_NEAR(shell.value().world().mass_kg(shell.value().bodies()[0].id).value(), 220, 1e-9);
  EXPECT_EQ(warm.value().world().state_hash(), off.value().world().state_hash());
  EXPECT_EQ(warm.value().shapes()[0]->tree.radius_m, off.value().shapes()[0]->tree.radius_m);
  EXPECT_EQ(warm.value().shapes()[0]->volume_m3, off.value().shapes()[0]->volume_m3);
  std::ofstream(folder.file("file")) << "";
  options.tree_cache->folder = folder.file("file");
  const Result<SceneRun> without = run_with_shape(folder, shape, options);
  ASSERT_TRUE(without);
  EXPECT_EQ(without.value().tree_cache_use().not_writable, 1U);
}

// A Scene is plain data, so a caller may have changed it since it was read.
TEST(SceneRun, RefusesASceneWhoseListsDoNotFitTogether) {
  const Scene sound = parse(scene_text(R"("generators": [{"grid": {"shape": "ball", "material": "hard",
                                           "count": [2, 2, 1], "spacing_m": 2}}], )"))
                          .value();
  const auto refused = [&](const auto& change) {
    Scene scene = sound;
    change(scene, std::get<GridGenerator>(scene.generators[0]));
    const Result<SceneRun> run = SceneRun::create(scene, serial());
    return run ? std::string("not refused") : run.error().message;
  };
  EXPECT_EQ(refused([](Scene&, GridGenerator&) {}), "not refused");
  const std::string materials = fmt::format("of {} materials", sound.materials.size());
  const std::string shapes = fmt::format("of {} shapes", sound.shapes.size());
  EXPECT_EQ(refused([](Scene& s, GridGenerator&) { s.bodies[0].shape = 99; }),
            "s.json: bodies[0].shape = 99, must be the index of one " + shapes);
  EXPECT_EQ(refused([](Scene& s, GridGenerator&) { s.bodies[0].material = 7; }),
            "s.json: bodies[0].material = 7, must be the index of one " + materials);
  EXPECT_EQ(refused([](Scene& s, GridGenerator&) { s.materials.clear(); }),
            "s.json: bodies[0].material = 0, must be the index of one of 0 materials");
  EXPECT_EQ(refused([](Scene&, GridGenerator& g) { g.kind.shapes = {99}; }),
            "s.json: generators[0].grid.shapes[0] = 99, must be the index of one " + shapes);
  EXPECT_EQ(refused([](Scene&, GridGenerator& g) { g.kind.shapes.clear(); }),
            "s.json: generators[0].grid.shapes = [], must name a shape");
  EXPECT_EQ(refused([](Scene&, GridGenerator& g) {
              g.count = {1ULL << 40U, 1ULL << 40U, 1ULL << 40U};
            }),
            "s.json: generators[0].grid.count[0] = 1099511627776, must be from 0 to 10000000");
  EXPECT_EQ(refused([](Scene&, GridGenerator& g) {
              g.count = {10000, 10000, 10000};
            }),
            "s.json: generators[0].grid.count: bodies = 100000000, must be from 0 to 10000000");
  EXPECT_EQ(refused([](Scene& s, GridGenerator&) { s.dt_s = std::numeric_limits<double>::quiet_NaN(); }),
            "s.json: dt_s = nan, must be > 0 and <= 1");
  EXPECT_EQ(refused([](Scene& s, GridGenerator&) { s = Scene{}; }), ": dt_s = 0, must be > 0 and <= 1");
}

TEST(SceneRun, RefusesANumberOfBodiesWithoutGenerators) {
  SceneRunOptions options = serial();
  options.bodies = 5;
  EXPECT_EQ(SceneRun::create(parse(scene_text("")).value(), options).error().message,
            "s.json: has no generators, so the number of bodies cannot be chosen");
}

TEST(SceneRun, RefusesBodiesThatTakeMoreMemoryThanItMayBeforeOneIsMade) {
  const Scene scene = parse(scene_text(R"("generators": [{"grid": {"shape": "ball", "material": "hard",
                                           "count": [1000, 100, 1], "spacing_m": 2}}], )",
                                       "[]"))
                          .value();
  SceneRunOptions options = serial();
  options.max_memory_bytes = 100U << 20U;
  EXPECT_EQ(SceneRun::create(scene, options).error().message,
            "s.json: 100000 bodies at once, of 100000 that are generated, take about 816 MiB, must be at most the 100 "
            "MiB that a run may take (--max-memory)");
  options.bodies = 1000;
  ASSERT_TRUE(SceneRun::create(scene, options).ok());
  options.bodies = 9'999'999;
  options.max_memory_bytes = std::uint64_t{60} << 30U;
  EXPECT_EQ(SceneRun::create(scene, options).error().kind, ErrorKind::BadInput);
}

TEST(SceneRun, OfAStreamWhoseBodiesLeaveThoseThatAreThereAtOnceTakeTheMemory) {
  // 1,000 come a frame.
  const auto stream = [](const char* life_s) {
    return parse(scene_text(fmt::format(R"("generators": [{{"stream": {{"shape": "ball", "material": "hard",
                              "per_second": 100000, "from_s": 0, "to_s": 1, "life_s": {},
                              "region_min_m": [0, 0, 0], "region_max_m": [9e4, 9e4, 9e4]}}}}], )",
                                        life_s),
                            "[]"))
        .value();
  };
  SceneRunOptions options = serial();
  options.max_memory_bytes = 100U << 20U;
  for (const char* life_s : {"1e-4", "0.005", "0.01"}) {
    EXPECT_TRUE(SceneRun::create(stream(life_s), options).ok()) << life_s << " s: some thousands are there";
    SceneRun run = SceneRun::create(stream(life_s), serial()).value();
    std::size_t most = 0;
    for (std::uint64_t frame = 0; frame < 20; ++frame) {
      ASSERT_TRUE(run.before_frame(frame).ok());
      most = std::max(most, run.bodies().size());
    }
    EXPECT_LE(static_cast<double>(most), io::body_numbers(stream(life_s), std::nullopt).at_once) << life_s;
    EXPECT_GE(most, 999U);
  }
  EXPECT_FALSE(SceneRun::create(stream("0.5"), options).ok()) << "50,000 are there";
}

TEST(SceneRun, WhatItsBodiesLeaveOfItsMemoryBoundsThePairsOfACrowd) {
  const Scene scene = parse(scene_text(R"("generators": [{"grid": {"shape": "ball", "material": "hard",
                                           "count": [2000, 1, 1], "spacing_m": 1e-6}}], )",
                                       "[]"))
                          .value();
  SceneRunOptions options;
  options.max_memory_bytes = 60U << 20U;
  SceneRun run = SceneRun::create(scene, options).value();
  const std::uint32_t pairs = run.world().settings().max_pairs;
  EXPECT_GT(pairs, 5'000U);
  EXPECT_LT(pairs, 20'000U) << "60 MiB without 39 MB, in pairs of 2.4 kB";
  const FrameReport report = run.world().step({});
  EXPECT_LE(report.candidate_pairs, pairs);
  EXPECT_GT(report.candidate_pairs, pairs / 2);
  EXPECT_GT(report.pairs_discarded, 1'000'000U);
  options.max_memory_bytes.reset();
  EXPECT_EQ(SceneRun::create(scene, options).value().world().settings().max_pairs, WorldSettings{}.max_pairs);
}

TEST(ScaledTree, HoldsTheScaledLeavesTooWhereTheyOnlyCover) {
  std::vector<Sphere> spheres;
  for (int i = 0; i < 20; ++i)
    spheres.push_back({Vec3(std::cos(i), 100 + std::sin(2.0 * i), 0.1 * i), 0.05 + 0.01 * (i % 7)});
  const SphereTree tree = tree_of_spheres(spheres).value();
  for (const double scale : {0.001, 0.3, 3.0, 1e4}) {
    const SphereTree scaled = io::scaled_tree(tree, scale, false);
    for (NodeIndex node = 0; node < tree.node_count(); ++node) {
      const double moved_m = (scaled.sphere(node).center_m - scale * tree.sphere(node).center_m).norm();
      EXPECT_GE(scaled.sphere(node).radius_m, scale * tree.sphere(node).radius_m + moved_m);
    }
  }
}

TEST(ScaledTree, StillHoldsTheScaledLeavesInEveryInnerSphere) {
  std::vector<Sphere> spheres;
  for (int i = 0; i < 60; ++i) {
    spheres.push_back({Vec3(std::cos(i), std::sin(2.0 * i), 0.1 * i), 0.05 + 0.01 * (i % 7)});
  }
  const Result<SphereTree> tree = tree_of_spheres(spheres);
  ASSERT_TRUE(tree);
  for (const double scale : {0.001, 0.3, 3.0, 1e4}) {
    const SphereTree scaled = io::scaled_tree(tree.value(), scale, true);
    for (NodeIndex node = 0; node < scaled.node_count(); ++node) {
      std::vector<NodeIndex> below{node};
      for (std::size_t i = 0; i < below.size(); ++i) {
        const NodeIndex at = below[i];
        for (NodeIndex c = 0; c < scaled.child_count[at]; ++c) below.push_back(scaled.first_child[at] + c);
        if (scaled.child_count[at] > 0) continue;
        const Sphere outer = scaled.sphere(node);
        const Sphere leaf = scaled.sphere(at);
        EXPECT_LE((outer.center_m - leaf.center_m).norm() + leaf.radius_m, outer.radius_m);
      }
    }
    EXPECT_FLOAT_EQ(scaled.radius_m.back() + 1, tree.value().radius_m.back() * static_cast<float>(scale) + 1);
  }
}

}  // namespace
}  // namespace poise::testing
