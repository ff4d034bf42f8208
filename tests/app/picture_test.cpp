// SPDX-License-Identifier: MIT
#include "app/picture/picture.h"

#include <gtest/gtest.h>

#include "scene/scene_text.h"

namespace poise::testing {
namespace {

constexpr std::uint32_t kWidth = 160;
constexpr std::uint32_t kHeight = 90;

using Pixel = std::array<int, 3>;

Pixel pixel_at(const io::Image& image, std::uint32_t x, std::uint32_t y) {
  const std::size_t at = 3 * (std::size_t{y} * image.width_px + x);
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

// A picture of a ball of one metre straight ahead at 10 m, and of optional other bodies.
io::Image picture_of(const std::string& more_bodies, int steps = 0) {
  const Result<Scene> scene =
      parse(scene_text(R"("camera": {"position_m": [-10, 0, 0], "look_at_m": [0, 0, 0], "vertical_fov_deg": 30}, )",
                       R"([{"shape": "ball", "material": "hard"})" + more_bodies + "]"));
  EXPECT_TRUE(scene) << scene.error().message;
  SceneRunOptions options;
  options.world.threads = 1;
  Result<SceneRun> run = SceneRun::create(scene.value(), options);
  EXPECT_TRUE(run) << run.error().message;
  StepInput input;
  for (int i = 0; i < steps; ++i) run.value().world().step(input);
  return io::draw_run(run.value(), kWidth, kHeight);
}

TEST(Picture, ShowsABallWhereItIsAndSkyBesideIt) {
  const io::Image image = picture_of("");
  ASSERT_EQ(image.rgb.size(), std::size_t{3} * kWidth * kHeight);
  const Pixel middle = pixel_at(image, kWidth / 2, kHeight / 2);
  const Pixel corner = pixel_at(image, 2, 2);
  EXPECT_LT(middle[2], 200) << "a grey ball";
  EXPECT_GT(corner[2], 230) << "a bright sky";
  // The radius of its outline; half the height is tan(15 degrees).
  const double radius_px = 0.5 * kHeight / std::tan(15 * 3.14159265358979 / 180) * 0.5 / std::sqrt(10 * 10 - 0.25);
  const auto row = [&](double offset_px) {
    return pixel_at(image, kWidth / 2, static_cast<std::uint32_t>(0.5 * kHeight + offset_px));
  };
  EXPECT_LT(row(radius_px - 2)[2], 200);
  EXPECT_GT(row(radius_px + 2)[2], 200);
}

TEST(Picture, TheNearerBodyHidesTheFartherOne) {
  const io::Image alone = picture_of("");
  const io::Image behind = picture_of(R"(, {"shape": "ball", "material": "hard", "position_m": [3, 0, 0]})");
  const io::Image before = picture_of(R"(, {"shape": "ball", "material": "hard", "position_m": [-3, 0, 0]})");
  EXPECT_EQ(behind.rgb, alone.rgb);
  EXPECT_NE(before.rgb, alone.rgb);
}

TEST(Picture, WhatIsBehindTheEyeIsNotDrawn) {
  EXPECT_EQ(picture_of(R"(, {"shape": "ball", "material": "hard", "position_m": [-13, 0, 0]})").rgb,
            picture_of("").rgb);
}

TEST(Picture, ABodyInContactHasTheColourOfItsLevel) {
  const Pixel free = pixel_at(picture_of(""), kWidth / 2, kHeight / 2);
  const Pixel touched = pixel_at(picture_of(R"(, {"shape": "ball", "material": "hard", "position_m": [0.9, 0, 0]})", 1),
                                 kWidth / 2, kHeight / 2);
  EXPECT_LT(std::abs(free[0] - free[1]), 12) << "grey";
  EXPECT_GT(touched[2], touched[1] + 30) << "violet: level 0";
}

TEST(Picture, PngBytesAreAPngOfTheSameSize) {
  const Result<std::string> png = io::png_bytes(picture_of(""));
  ASSERT_TRUE(png) << png.error().message;
  const std::string& bytes = png.value();
  EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(bytes.substr(12, 4), "IHDR");
  EXPECT_EQ(static_cast<unsigned char>(bytes[19]), kWidth);
  EXPECT_EQ(static_cast<unsigned char>(bytes[23]), kHeight);
}

TEST(Picture, AnEmptyImageIsRefused) { EXPECT_FALSE(io::png_bytes(io::Image{}).ok()); }

}  // namespace
}  // namespace poise::testing
