// SPDX-License-Identifier: MIT
#include "app/picture/tree_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "app/picture/panel_raster.h"
#include "app/picture/pixel_text.h"
#include "geometry/mesh/procedural.h"

namespace poise::testing {
namespace {

using Pixel = std::array<int, 3>;

Pixel pixel_at(const io::Image& image, std::uint32_t x, std::uint32_t y) {
  const std::size_t at = 3 * (std::size_t{y} * image.width_px + x);
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

TriangleMesh cube() { return geometry::make_procedural_shape("cube").value(); }

SphereTree tree_of(const std::vector<Sphere>& spheres) { return tree_of_spheres(spheres).value(); }

io::TreePictureSettings small() {
  io::TreePictureSettings settings;
  settings.width_px = 400;
  settings.threads = 1;
  return settings;
}

io::Image drawn(const TriangleMesh& mesh, const std::vector<io::DrawnTree>& trees,
                const io::TreePictureSettings& settings) {
  const Result<io::Image> image = io::draw_trees(mesh, trees, settings);
  EXPECT_TRUE(image) << image.error().message;
  return image ? image.value() : io::Image{};
}

/// Width in pixels of everything that is not background in one row of a panel.
std::uint32_t width_in_row(const io::Image& image, std::uint32_t row, std::uint32_t from, std::uint32_t until) {
  std::uint32_t count = 0;
  for (std::uint32_t x = from; x < until; ++x) {
    if (pixel_at(image, x, row) != pixel_at(image, 0, 0)) ++count;
  }
  return count;
}

TEST(TreePicture, ShowsTheMeshGreyAndTheBallToScaleBesideIt) {
  // The bounding ball of the cube touches its eight corners.
  const double radius_m = 0.35 * std::sqrt(3.0);
  const SphereTree ball = tree_of({{Vec3::Zero(), radius_m}});
  const io::Image image = drawn(cube(), {{&ball, ""}}, small());
  ASSERT_EQ(image.width_px, 400U);
  ASSERT_EQ(image.rgb.size(), std::size_t{3} * image.width_px * image.height_px);
  // The panels are 190 pixels wide and high, since the ball fills its panel; they begin 10 pixels below the upper edge.
  const std::uint32_t middle = 10 + 95;
  const Pixel mesh = pixel_at(image, 100, middle);
  EXPECT_LT(std::abs(mesh[0] - mesh[2]), 12) << "grey";
  EXPECT_NEAR(width_in_row(image, middle, 200, 400), 190, 2) << "the ball is as wide as its panel";
  // Seen from a corner the cube is narrower than its bounding ball, and wider than its edge.
  const double px_per_m = 190 / (2 * radius_m);
  EXPECT_LT(width_in_row(image, middle, 0, 200), 2 * radius_m * px_per_m);
  EXPECT_GT(width_in_row(image, middle, 0, 200), 0.7 * px_per_m);
}

TEST(TreePicture, GivesAPointTheColourOfItsDistanceToTheMesh) {
  // A ball inside the cube, and a large one: in front they protrude by 0 and by more than a tenth of the diagonal.
  const SphereTree inside = tree_of({{Vec3::Zero(), 0.3}});
  const SphereTree outside = tree_of({{Vec3::Zero(), 1.0}});
  const Pixel calm = pixel_at(drawn(cube(), {{&inside, ""}}, small()), 300, 105);
  const Pixel hot = pixel_at(drawn(cube(), {{&outside, ""}}, small()), 300, 105);
  EXPECT_GT(calm[2], calm[0] + 30) << "blue";
  EXPECT_GT(hot[0], hot[2] + 60) << "red";
}

TEST(TreePicture, ColoursGoFromBlueOverYellowToRedByRatios) {
  EXPECT_EQ(io::protrusion_color(0), io::protrusion_color(0.001));
  EXPECT_EQ(io::protrusion_color(0.1), io::protrusion_color(7));
  const auto middle = io::protrusion_color(0.01);
  EXPECT_GT(middle[0], 0.9);
  EXPECT_GT(middle[1], 0.8);
  EXPECT_LT(middle[2], 0.6);
  EXPECT_GT(io::protrusion_color(0.001)[2], io::protrusion_color(0.001)[0]);
  EXPECT_GT(io::protrusion_color(0.1)[0], io::protrusion_color(0.1)[2]);
}

TEST(TreePicture, IsTheSameOnAnyNumberOfThreads) {
  TreeBuildOptions build;
  build.depth = 1;
  build.preset = TreePreset::Fast;
  const SphereTree tree = build_sphere_tree(cube(), build).value();
  io::TreePictureSettings settings = small();
  const io::Image one = drawn(cube(), {{&tree, ""}}, settings);
  settings.threads = 4;
  EXPECT_EQ(drawn(cube(), {{&tree, ""}}, settings).rgb, one.rgb);
}

TEST(TreePicture, SeveralTreesStandBelowOneAnother) {
  const SphereTree ball = tree_of({{Vec3::Zero(), 0.7}});
  const io::Image one = drawn(cube(), {{&ball, ""}}, small());
  const io::Image two = drawn(cube(), {{&ball, "a"}, {&ball, "b"}}, small());
  EXPECT_EQ(two.width_px, one.width_px);
  EXPECT_GT(two.height_px, one.height_px + 190);
  EXPECT_EQ(pixel_at(two, 300, 105), pixel_at(one, 300, 105));
}

TEST(TreePicture, TurnsTheAxisThatIsAskedForUpward) {
  // A tall box along y: with y upward its panel is higher than wide.
  TriangleMesh tall = cube();
  for (Vec3& v : tall.vertices_m) v.y() *= 3;
  const SphereTree speck = tree_of({{Vec3::Zero(), 0.01}});
  io::TreePictureSettings settings = small();
  settings.up = Vec3::UnitY();
  const std::uint32_t upright = drawn(tall, {{&speck, ""}}, settings).height_px;
  settings.up = Vec3::UnitZ();
  const std::uint32_t lying = drawn(tall, {{&speck, ""}}, settings).height_px;
  EXPECT_GT(upright, lying);
}

TEST(TreePicture, ShowsTheSideThatIsTheFront) {
  // A ball that protrudes from one side of the cube is visible from there, and hidden by the cube from behind.
  const SphereTree bump = tree_of({{Vec3(0, 0.3, 0), 0.2}, {Vec3::Zero(), 0.34}});
  const auto warm = [&](const Vec3& front) {
    io::TreePictureSettings settings = small();
    settings.front = front;
    const io::Image image = drawn(cube(), {{&bump, ""}}, settings);
    std::size_t count = 0;  // number in the panel of level 1
    for (std::uint32_t y = 10; y < 90; ++y) {
      for (std::uint32_t x = 270; x < 390; ++x) {
        const Pixel pixel = pixel_at(image, x, y);
        count += pixel[0] > pixel[2] + 60 ? 1U : 0U;
      }
    }
    return count;
  };
  EXPECT_GT(warm(Vec3::UnitY()), 3 * warm(-Vec3::UnitY()));
}

TEST(TreePicture, TheUsualFrontIsWhereModellersHaveIt) {
  EXPECT_EQ(io::usual_front(Vec3::UnitZ()), Vec3(-Vec3::UnitY()));
  EXPECT_EQ(io::usual_front(Vec3::UnitY()), Vec3::UnitZ());
  for (const Vec3& up : {Vec3(Vec3::UnitX()), Vec3(-Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
    const Mat3 to_eye = io::three_quarter_view(up, io::usual_front(up));
    EXPECT_NEAR(to_eye.determinant(), -1, 1e-12) << "right, up and forward";
    EXPECT_NEAR((to_eye * to_eye.transpose() - Mat3::Identity()).norm(), 0, 1e-12);
    EXPECT_GT(to_eye.row(1).dot(up.transpose()), 0.9);
    EXPECT_LT(to_eye.row(2).dot(io::usual_front(up).transpose()), -0.7) << "looks at the front";
  }
}

TEST(TreePicture, RefusesWhatCannotBeDrawn) {
  const SphereTree ball = tree_of({{Vec3::Zero(), 0.7}});
  const SphereTree none;
  const auto refusal = [](const TriangleMesh& mesh, const std::vector<io::DrawnTree>& trees, std::uint32_t width_px) {
    io::TreePictureSettings settings = small();
    settings.width_px = width_px;
    const Result<io::Image> image = io::draw_trees(mesh, trees, settings);
    return image ? std::string() : image.error().message;
  };
  EXPECT_NE(refusal({}, {{&ball, ""}}, 400).find("no triangle"), std::string::npos);
  EXPECT_NE(refusal(cube(), {}, 400).find("no tree"), std::string::npos);
  EXPECT_NE(refusal(cube(), {{&none, ""}}, 400).find("no node"), std::string::npos);
  EXPECT_NE(refusal(cube(), {{&ball, ""}}, 199).find("width = 199"), std::string::npos);
  EXPECT_NE(refusal(cube(), {{&ball, ""}}, 10001).find("width = 10001"), std::string::npos);
  io::TreePictureSettings askew = small();
  askew.front = Vec3::UnitZ();
  const std::vector<io::DrawnTree> one{{&ball, ""}};
  EXPECT_EQ(io::draw_trees(cube(), one, askew).error().message,
            "picture: up and front must be unit vectors square to each other");
}

TEST(PixelText, WritesDotsWhereItSaysAndNothingOutsideTheImage) {
  io::Image image{20, 12, std::vector<std::uint8_t>(std::size_t{3} * 20 * 12, 255)};
  io::draw_text(image, "1", 2, 1, 1, {0, 0, 0});
  // The stem of a 1 is the third column, in all seven rows.
  for (std::uint32_t y = 1; y < 8; ++y) EXPECT_EQ(pixel_at(image, 4, y), (Pixel{0, 0, 0})) << y;
  EXPECT_EQ(pixel_at(image, 2, 1), (Pixel{255, 255, 255}));
  EXPECT_EQ(io::text_width_px("ab", 2), 22U);
  const std::vector<std::uint8_t> before = image.rgb;
  io::draw_text(image, "888", -40, -40, 3, {0, 0, 0});
  io::draw_text(image, "8", 20, 12, 3, {0, 0, 0});
  EXPECT_EQ(image.rgb, before);
}

}  // namespace
}  // namespace poise::testing
