// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck/detail/Configuration.h>
#include <rapidcheck/gtest.h>

#include <set>
#include <stop_token>
#include <thread>

#include "geometry/mesh/bumpy_ball.h"
#include "meshes.h"

// Guarantees of the builder for any mesh: coverage, progress, a prompt stop, and presets that are no worse than faster
// ones.
namespace poise {
namespace {

TriangleMesh shape_mesh(std::string_view kind) { return geometry::make_procedural_shape(kind).value(); }

/// The surface of some cells of a 3 x 3 x 3 grid, welded: closed, with edges and corners where pieces only touch.
TriangleMesh boxes_mesh(std::uint32_t cells) {
  const auto full = [&](const Eigen::Vector3i& at) {
    if (at.minCoeff() < 0 || at.maxCoeff() > 2) return false;
    return (cells >> static_cast<unsigned>(at.x() + 3 * at.y() + 9 * at.z()) & 1U) != 0;
  };
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> corners;
  const auto corner = [&](const Eigen::Vector3i& at) {
    const auto [place, added] =
        corners.try_emplace({at.x(), at.y(), at.z()}, static_cast<std::uint32_t>(mesh.vertices_m.size()));
    if (added) mesh.vertices_m.emplace_back(at.cast<double>());
    return place->second;
  };
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i at(i % 3, i / 3 % 3, i / 9);
    if (!full(at)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + 1) % 3);
      const Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + 2) % 3);
      for (const int side : {0, 1}) {
        if (full(at + (2 * side - 1) * Eigen::Vector3i::Unit(axis))) continue;
        const Eigen::Vector3i low = at + side * Eigen::Vector3i::Unit(axis);
        const std::array<std::uint32_t, 4> q{corner(low), corner(low + u), corner(low + u + v), corner(low + v)};
        if (side == 1) {
          mesh.triangles.insert(mesh.triangles.end(), {{q[0], q[1], q[2]}, {q[0], q[2], q[3]}});
        } else {
          mesh.triangles.insert(mesh.triangles.end(), {{q[0], q[2], q[1]}, {q[0], q[3], q[2]}});
        }
      }
    }
  }
  return mesh;
}

/// One of three families of closed meshes, stretched by up to three along an axis, bent and rotated, from 1e-3 to 1e3 m
/// in size, and moved by up to a hundred times its size.
TriangleMesh random_mesh() {
  const int family = *rc::gen::inRange(0, 3);
  const std::uint64_t seed = *rc::gen::arbitrary<std::uint64_t>();
  std::mt19937_64 random(seed);
  TriangleMesh mesh;
  if (family == 0) {
    mesh = geometry::bumpy_ball(320).value();
  } else if (family == 1) {
    mesh = boxes_mesh(static_cast<std::uint32_t>(random() & random()) | 1U << (random() % 27));
  } else {
    const auto shapes = geometry::procedural_shapes();
    mesh = shape_mesh(shapes[random() % shapes.size()]);
  }
  const Vec3 stretch = test::random_in_box(random, Vec3::Ones(), Vec3::Constant(3));
  const double bend = 0.3 * test::uniform(random);
  for (Vec3& v : mesh.vertices_m) {
    v = v.cwiseProduct(stretch);
    v.z() += bend * v.x() * v.x();
  }
  const double factor = std::pow(10.0, 6 * test::uniform(random) - 3);
  const Vec3 axis = test::random_in_box(random, Vec3::Constant(0.1), Vec3::Ones()).normalized();
  const Mat3 turn = Eigen::AngleAxisd(6 * test::uniform(random), axis).toRotationMatrix();
  return test::moved(std::move(mesh), factor, turn,
                     factor * test::random_in_box(random, Vec3::Constant(-100), Vec3::Constant(100)));
}

std::size_t uncovered(const SphereTree& tree, const std::vector<Vec3>& points) {
  const std::size_t levels = std::size_t{tree.depth()} + 1;
  return static_cast<std::size_t>(
      std::ranges::count_if(points, [&](const Vec3& p) { return test::levels_covered(tree, p) < levels; }));
}

TEST(SphereTreeOfAnyClosedMesh, HasAChainOfNodesForEveryPointOfSurfaceAndInside) {
  rc::detail::TestParams few = rc::detail::configuration().testParams;
  few.maxSuccess = std::min(few.maxSuccess, 4);
  few.disableShrinking = true;
  const auto result = rc::detail::checkTestable(
      [] {
        const TriangleMesh mesh = random_mesh();
        const auto depth = static_cast<Level>(*rc::gen::inRange(1, 3));
        const auto tree = build_sphere_tree(
            mesh, {.depth = depth, .preset = TreePreset::Fast, .seed = *rc::gen::arbitrary<std::uint64_t>()});
        RC_ASSERT(tree.ok());
        RC_ASSERT(uncovered(tree.value(), test::surface_points(mesh, 1000)) == 0U);
        RC_ASSERT(uncovered(tree.value(), test::inside_points(mesh, 200)) == 0U);
      },
      rc::detail::TestMetadata{}, few);
  std::ostringstream said;
  rc::detail::printResultMessage(result, said);
  EXPECT_TRUE(result.is<rc::detail::SuccessResult>()) << said.str();
}

TEST(TreeProgress, AscendsFromZeroToOneOnTheCallingThread) {
  const TriangleMesh mesh = shape_mesh("l");
  for (const int threads : {1, 3}) {
    std::vector<double> shares;
    std::set<std::thread::id> callers;
    const auto tree = build_sphere_tree(
        mesh, {.depth = 1, .preset = TreePreset::Fast, .threads = threads, .progress = [&](double share) {
                 shares.push_back(share);
                 callers.insert(std::this_thread::get_id());
               }});
    ASSERT_TRUE(tree.ok());
    ASSERT_GT(shares.size(), 8U);
    EXPECT_EQ(shares.front(), 0);
    EXPECT_EQ(shares.back(), 1);
    EXPECT_TRUE(std::ranges::is_sorted(shares));
    EXPECT_EQ(callers, std::set{std::this_thread::get_id()});
  }
}

TEST(TreeBuild, EndsAsCancelledWhereverItIsStopped) {
  const TriangleMesh mesh = shape_mesh("l");
  for (const double when : {0.0, 0.2, 0.5, 0.8}) {
    std::stop_source stop;
    double last = 0;
    const auto tree = build_sphere_tree(mesh, {.depth = 1,
                                               .preset = TreePreset::Fast,
                                               .threads = 2,
                                               .progress =
                                                   [&](double share) {
                                                     last = share;
                                                     if (share >= when) stop.request_stop();
                                                   },
                                               .stop = stop.get_token()});
    ASSERT_FALSE(tree.ok()) << when;
    EXPECT_EQ(tree.error().kind, ErrorKind::Cancelled) << when;
    EXPECT_LT(last, 1) << when;
  }
}

TEST(TreeBuild, StoppedBeforeItBeginsDoesNothing) {
  std::stop_source stop;
  stop.request_stop();
  double last = 0;
  // At this depth the best tree would take minutes.
  const auto tree = build_sphere_tree(shape_mesh("jack"), {.depth = 4,
                                                           .preset = TreePreset::Best,
                                                           .progress = [&](double share) { last = share; },
                                                           .stop = stop.get_token()});
  ASSERT_FALSE(tree.ok());
  EXPECT_EQ(tree.error().kind, ErrorKind::Cancelled);
  EXPECT_EQ(last, 0);
}

TEST(TreeBuild, EndsEarlyForABallButNotForAThinPlate) {
  const TreeBuildOptions options{.depth = 2, .preset = TreePreset::Fast};
  EXPECT_EQ(build_sphere_tree(test::ball_mesh(1, 5), options).value().node_count(), 1U);
  EXPECT_GT(build_sphere_tree(shape_mesh("slab"), options).value().node_count(), 60U);
}

/// Figures of a tree of a jack, with its coverage checked.
std::vector<TreeLevelFigures> figures_of(TreePreset preset, int depth) {
  const TriangleMesh mesh = shape_mesh("jack");
  const SphereTree tree = build_sphere_tree(mesh, {.depth = static_cast<Level>(depth), .preset = preset}).value();
  EXPECT_EQ(uncovered(tree, test::surface_points(mesh, 3000)), 0U);
  EXPECT_EQ(uncovered(tree, test::inside_points(mesh, 300)), 0U);
  return measure_tree_quality(tree, mesh, {.samples = 20000}).value();
}

void expect_no_worse(const std::vector<TreeLevelFigures>& longer, const std::vector<TreeLevelFigures>& shorter) {
  // A tolerance of a few per cent for the choice of the seed.
  for (std::size_t level = 1; level < longer.size(); ++level) {
    EXPECT_LE(longer[level].protrusion_mean_m, 1.03 * shorter[level].protrusion_mean_m) << "level " << level;
    EXPECT_LE(longer[level].volume_ratio, 1.02 * shorter[level].volume_ratio) << "level " << level;
  }
}

TEST(TreePresets, CoverAndDefaultFitsAtLeastAsWellAsFastOnEveryLevel) {
  expect_no_worse(figures_of(TreePreset::Default, 2), figures_of(TreePreset::Fast, 2));
}

TEST(TreePresets, CoverAndBestFitsAtLeastAsWellAsFast) {
  expect_no_worse(figures_of(TreePreset::Best, 1), figures_of(TreePreset::Fast, 1));
}

}  // namespace
}  // namespace poise
