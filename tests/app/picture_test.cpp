// SPDX-License-Identifier: MIT
#include "app/picture/picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/picture/drawn_frame.h"
#include "app/picture/frame_picture.h"
#include "app/picture/picture_options.h"
#include "capture/observe.h"
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

io::PictureSettings small() {
  io::PictureSettings settings;
  settings.size_px = {{kWidth, kHeight}};
  settings.plain = true;
  return settings;
}

// A picture of a ball of one metre straight ahead at 10 m, and of optional other bodies.
io::Image picture_of(const std::string& more_bodies, int steps = 0, const io::PictureSettings& settings = small()) {
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
  const Result<io::DrawnFrame> frame =
      io::drawn_frame(scene.value(), run.value(), static_cast<std::uint64_t>(steps), 0.01 * steps);
  EXPECT_TRUE(frame) << frame.error().message;
  return io::FramePictures(capture::captured_shapes(scene.value(), run.value()), settings).draw(frame.value());
}

// A square plate of two triangles, 2 m across, that the sphere tree of a body has one ball of 1.5 m for.
capture::CapturedShape plate() {
  capture::CapturedShape shape;
  shape.radius_m = 1.5;
  shape.vertices_m = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  shape.corners = {0, 1, 2, 0, 2, 3};
  shape.levels = {{{0, 0, 0, 1.5F}}};
  return shape;
}

// The plate seen from 10 m above, with what is added to the frame.
io::DrawnFrame above_plate() {
  io::DrawnFrame frame;
  frame.scene = "plate";
  frame.view.present = true;
  frame.view.position_m = {0, 0, 10};
  frame.view.forward = frame.view.gaze = -Vec3::UnitZ();
  frame.view.up = Vec3::UnitY();
  frame.view.vertical_fov_rad = 0.6;
  io::DrawnBody& body = frame.bodies.emplace_back();
  body.level = Level{1};
  return frame;
}

std::size_t different_pixels(const io::Image& a, const io::Image& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) count += std::equal(&a.rgb[i], &a.rgb[i] + 3, &b.rgb[i]) ? 0U : 1U;
  return count;
}

TEST(Picture, ShowsABallWhereItIsAndSkyBesideIt) {
  const io::Image image = picture_of("");
  ASSERT_EQ(image.rgb.size(), std::size_t{3} * kWidth * kHeight);
  const Pixel middle = pixel_at(image, kWidth / 2, kHeight / 2);
  const Pixel corner = pixel_at(image, 2, 2);
  EXPECT_LT(middle[2], 215) << "a grey ball";
  EXPECT_GT(corner[2], 230) << "a bright sky";
  // The radius of its outline; half the height is tan(15 degrees).
  const double radius_px = 0.5 * kHeight / std::tan(15 * 3.14159265358979 / 180) * 0.5 / std::sqrt(10 * 10 - 0.25);
  const auto row = [&](double offset_px) {
    return pixel_at(image, kWidth / 2, static_cast<std::uint32_t>(0.5 * kHeight + offset_px));
  };
  EXPECT_LT(row(radius_px - 2)[2], 215);
  EXPECT_GT(row(radius_px + 2)[2], 215);
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
  EXPECT_LT(std::abs(free[0] - free[1]), 15) << "grey";
  EXPECT_GT(touched[2], touched[1] + 30) << "violet: level 0";
}

TEST(Picture, AMeshIsDrawnByItsTrianglesAndNotByItsSpheres) {
  const io::Image image = io::FramePictures({plate()}, small()).draw(above_plate());
  // The half height of the picture is 10 tan(0.3) m.
  const double px_per_m = 0.5 * kHeight / (10 * std::tan(0.3));
  const auto beside = [&](double x_m) {
    return pixel_at(image, static_cast<std::uint32_t>(0.5 * kWidth + px_per_m * x_m), kHeight / 2);
  };
  EXPECT_GT(beside(0)[2], beside(0)[0] + 60) << "blue: level 1";
  EXPECT_EQ(beside(0.85), beside(0.5));
  EXPECT_GT(beside(1.25)[0], 210) << "sky, where the ball of the tree reaches";
}

TEST(Picture, ATriangleThatReachesBehindTheEyeIsDrawnAsFarAsItIsSeen) {
  io::DrawnFrame frame = above_plate();
  frame.view.position_m = {0, 0, 0.5};
  frame.view.forward = Vec3(1, 0, -0.5).normalized();
  frame.view.up = Vec3::UnitZ();
  const io::Image image = io::FramePictures({plate()}, small()).draw(frame);
  const Pixel below = pixel_at(image, kWidth / 2, kHeight - 3);
  EXPECT_GT(below[2], below[0] + 60) << "the plate under the eye";
  EXPECT_GT(pixel_at(image, kWidth / 2, 3)[0], 220) << "sky";
}

TEST(Picture, PolygonsStaticBodiesAndThoseThatTouchNothingHaveColoursOfTheirOwn) {
  const auto middle = [](const io::DrawnFrame& frame) {
    return pixel_at(io::FramePictures({plate()}, small()).draw(frame), kWidth / 2, kHeight / 2);
  };
  io::DrawnFrame frame = above_plate();
  frame.bodies[0].level = kPolygonBin;
  const Pixel polygons = middle(frame);
  frame.bodies[0].given = true;
  const Pixel given = middle(frame);
  frame.bodies[0].given = false;
  frame.bodies[0].level.reset();
  const Pixel untouched = middle(frame);
  EXPECT_GT(polygons[0], polygons[2] + 120) << "orange";
  EXPECT_GT(given[0], given[2] + 25) << "brown";
  EXPECT_LT(given[0], given[2] + 80);
  EXPECT_LE(untouched[0], untouched[2]) << "grey";
}

TEST(Picture, EachLevelIsLighterThanTheOneBefore) {
  const auto lightness = [](int level) {
    const std::array<double, 3> c = io::level_color(level);
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
  };
  for (int level = 1; level <= 4; ++level) EXPECT_GT(lightness(level), lightness(level - 1) + 0.1) << level;
}

TEST(Picture, ABodyThrowsAShadowOnTheGround) {
  capture::CapturedShape floor;
  floor.plane = true;
  floor.normal = {0, 0, 1};
  floor.offset_m = -1;
  io::DrawnFrame frame = above_plate();
  io::DrawnBody& ground = frame.bodies.emplace_back();
  ground.shape = 1;
  ground.given = true;
  const io::Image with = io::FramePictures({plate(), floor}, small()).draw(frame);
  frame.bodies.erase(frame.bodies.begin());
  const io::Image without = io::FramePictures({plate(), floor}, small()).draw(frame);
  const double plate_px = std::pow(2 * 0.5 * kHeight / (10 * std::tan(0.3)), 2);
  EXPECT_GT(static_cast<double>(different_pixels(with, without)), 1.1 * plate_px) << "the plate and its shadow";
}

TEST(Picture, WallsOfATrayAreDrawnLowAndOnTheFarSidesAlone) {
  std::vector<capture::CapturedShape> shapes(5);
  const std::array<std::array<double, 3>, 5> normals{{{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}};
  io::DrawnFrame frame;
  frame.view.present = true;
  frame.view.position_m = {-30, 0, 3};
  frame.view.forward = frame.view.gaze = Vec3::UnitX();
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    shapes[i].plane = true;
    shapes[i].normal = normals[i];
    shapes[i].offset_m = i == 0 ? 0 : -5;
    frame.bodies.emplace_back().shape = static_cast<std::uint32_t>(i);
    frame.bodies.back().given = true;
  }
  const io::Image tray = io::FramePictures(shapes, small()).draw(frame);
  frame.bodies.resize(1);
  const io::Image floor = io::FramePictures(shapes, small()).draw(frame);
  // The far wall is 35 m ahead, 10 m wide and 1 m high.
  const double px_per_m = 0.5 * kHeight / std::tan(0.5 * frame.view.vertical_fov_rad) / 35;
  const double changed = static_cast<double>(different_pixels(tray, floor));
  EXPECT_GT(changed, 10 * px_per_m * px_per_m) << "more than the far wall: the two beside it too";
  EXPECT_LT(changed, 40 * px_per_m * px_per_m);
}

TEST(Picture, ACameraOfOnesOwnAndASizeTakeThePlaceOfTheScenes) {
  io::PictureSettings settings = small();
  settings.size_px = {{100, 70}};
  settings.camera = io::PictureCamera{{0, 0, 10}, {0, 0, 0}, 0.6};  // straight down
  io::DrawnFrame frame = above_plate();
  const io::Image from_above = io::FramePictures({plate()}, settings).draw(frame);
  EXPECT_EQ(from_above.width_px, 100U);
  EXPECT_EQ(from_above.height_px, 70U);
  frame.view.position_m = {0, 0, -500};
  EXPECT_EQ(io::FramePictures({plate()}, settings).draw(frame).rgb, from_above.rgb);
}

TEST(Picture, WordsAndTheRingOfTheGazeAreLeftOutOfAPlainOne) {
  io::PictureSettings settings;
  settings.size_px = {{640, 360}};
  settings.plain = true;
  io::DrawnFrame frame = above_plate();
  frame.view.gaze = Vec3(0.1, 0, -1).normalized();
  const io::Image plain = io::FramePictures({plate()}, settings).draw(frame);
  settings.plain = false;
  const io::Image full = io::FramePictures({plate()}, settings).draw(frame);
  std::size_t above = 0;
  for (std::uint32_t y = 0; y < 300; ++y) {
    for (std::uint32_t x = 0; x < 640; ++x) {
      if (pixel_at(plain, x, y) == pixel_at(full, x, y)) continue;
      ++above;
      // The gaze meets the plate a metre beside its middle.
      const double px_per_m = 180 / (10 * std::tan(0.3));
      EXPECT_LT(std::abs(std::hypot(x + 0.5 - 320 - px_per_m, y + 0.5 - 180) - 0.035 * 360), 4);
    }
  }
  EXPECT_GT(above, 100U);
  EXPECT_GT(different_pixels(plain, full), above + 10000) << "the legend";
}

TEST(Picture, DoesNotDependOnTheNumberOfThreads) {
  io::PictureSettings settings = small();
  settings.threads = 1;
  const io::Image one = io::FramePictures({plate()}, settings).draw(above_plate());
  settings.threads = 3;
  EXPECT_EQ(io::FramePictures({plate()}, settings).draw(above_plate()).rgb, one.rgb);
}

TEST(Picture, CamerasAndSizesAreReadAndWrongOnesRefused) {
  const Result<io::PictureCamera> camera = io::parse_picture_camera("--camera", "1,-2.5,3e1:0,0,1:40");
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ(camera.value().position_m, Vec3(1, -2.5, 30));
  EXPECT_EQ(camera.value().look_at_m, Vec3(0, 0, 1));
  EXPECT_NEAR(camera.value().vertical_fov_rad, 40 * 3.14159265358979 / 180, 1e-12);
  for (const char* wrong : {"", "1,2,3", "1,2:3,4,5", "1,2,3:4,5", "1,2,3:4,5,6:", "1,2,3:4,5,6:50x", "1,2,3 4,5,6",
                            "1,2,3:4,5,nan", "1,2,3:4,5,2e9"}) {
    const Result<io::PictureCamera> refused = io::parse_picture_camera("--camera", wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_NE(refused.error().message.find(std::string("--camera = ") + wrong + ", must be x,y,z:tx,ty,tz or"),
              std::string::npos)
        << refused.error().message;
  }
  EXPECT_EQ(io::parse_picture_camera("--camera", "1,2,3:4,5,6:180").error().message,
            "--camera = 1,2,3:4,5,6:180, the angle must be above 0 and below 180 degrees");
  EXPECT_EQ(io::parse_picture_camera("--camera", "1,2,3:1,2,3").error().message,
            "--camera = 1,2,3:1,2,3, the camera must look at a point at least 1e-6 m from where it stands");
  EXPECT_EQ(io::parse_picture_size("--picture-size", "640x360").value(), (std::array<std::uint32_t, 2>{640, 360}));
  for (const char* wrong : {"", "640", "640x", "x360", "63x360", "640x4097", "-640x360", "640x360x2", "640 x 360"}) {
    EXPECT_EQ(io::parse_picture_size("--picture-size", wrong).error().message,
              std::string("--picture-size = ") + wrong + ", must be WxH with whole numbers from 64 to 4096");
  }
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
