// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/bytes.h"
#include "capture/captures.h"
#include "capture/header.h"
#include "capture/packed_pose.h"

namespace poise::capture {
namespace {

using nlohmann::ordered_json;
using testing::some_header;

TEST(CaptureHeaderText, GivesBackTheHeader) {
  const CaptureHeader written = some_header(true);
  const Result<CaptureHeader> read = read_header(header_json(written));
  ASSERT_TRUE(read.ok()) << read.error().message;
  const CaptureHeader& header = read.value();
  EXPECT_EQ(header.scene, written.scene);
  EXPECT_EQ(header.command, written.command);
  EXPECT_EQ(header.build.commit, "abc");
  EXPECT_EQ(header.machine.cores, 8);
  EXPECT_EQ(header.dt_s, written.dt_s);
  EXPECT_EQ(header.deadline_ms, 8);
  EXPECT_EQ(header.frames_asked, 100U);
  EXPECT_EQ(header.gravity_mps2, written.gravity_mps2);
  EXPECT_EQ(header.policy, "perceptual");
  EXPECT_EQ(header.position_step_m, 0.001);
  EXPECT_EQ(header.orientation_steps, 4096U);
  EXPECT_TRUE(header.contacts);
  ASSERT_TRUE(header.camera);
  EXPECT_EQ(header.camera->resolution_px[1], 720);
  EXPECT_TRUE(header.camera->moves);
  EXPECT_EQ(header.materials.at(0).density_kgpm3, 700);
  ASSERT_EQ(header.shapes.size(), 3U);
  EXPECT_EQ(header.shapes[1].name, "stone");
  EXPECT_TRUE(header.shapes[2].plane);
  EXPECT_EQ(header.shapes[2].normal[2], 1);
  const ordered_json json = ordered_json::parse(header_json(written));
  EXPECT_EQ(json.at("orientation_error_rad"), orientation_error_rad(4096)) << "for readers that do not compute it";
  EXPECT_EQ(json.at("shapes").at(1).at("triangles"), 4);
}

TEST(CaptureHeaderText, HasNullForWhatIsNotThere) {
  CaptureHeader written = some_header();
  written.deadline_ms.reset();
  written.frames_asked.reset();
  written.camera.reset();
  const Result<CaptureHeader> read = read_header(header_json(written));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_FALSE(read.value().deadline_ms);
  EXPECT_FALSE(read.value().frames_asked);
  EXPECT_FALSE(read.value().camera);
}

TEST(CaptureHeaderText, IsRefusedWithFieldValueAndRule) {
  const auto refused = [](const std::function<void(ordered_json&)>& change) {
    ordered_json json = ordered_json::parse(header_json(some_header()));
    change(json);
    const Result<CaptureHeader> read = read_header(json.dump());
    return read ? std::string("accepted") : read.error().message;
  };
  EXPECT_EQ(refused([](ordered_json&) {}), "accepted");
  EXPECT_EQ(refused([](ordered_json& j) { j["schema"] = "poise.capture/2"; }),
            "HEAD: schema = \"poise.capture/2\", must be poise.capture/1; did you mean \"poise.capture/1\"?");
  EXPECT_EQ(refused([](ordered_json& j) { j.erase("dt_s"); }), "HEAD: dt_s: missing, and it is required");
  EXPECT_EQ(refused([](ordered_json& j) { j["dt_s"] = 0; }), "HEAD: dt_s = 0, must be > 0");
  EXPECT_EQ(refused([](ordered_json& j) { j["orientation_steps"] = 3; }),
            "HEAD: orientation_steps = 3, must be a whole number from 16 to 1048576");
  EXPECT_EQ(refused([](ordered_json& j) { j["command"][1] = 7; }), "HEAD: command[1] = 7, must be a text");
  EXPECT_EQ(refused([](ordered_json& j) { j["materials"] = "wood"; }), "HEAD: materials = \"wood\", must be an array");
  EXPECT_EQ(refused([](ordered_json& j) { j["shapes"][1]["levels"] = 9; }),
            "HEAD: shapes[1].levels = 9, must be a whole number from 0 to 7");
  EXPECT_EQ(refused([](ordered_json& j) { j["shapes"][2].erase("normal"); }),
            "HEAD: shapes[2].normal: missing, and it is required");
}

TEST(CapturedShapeBytes, GiveBackTheShape) {
  const CapturedShape written = some_header().shapes[1];
  CapturedShape read;
  ASSERT_TRUE(read_shape(shape_bytes(1, written), 1, read).ok());
  EXPECT_EQ(read.vertices_m, written.vertices_m);
  EXPECT_EQ(read.corners, written.corners);
  ASSERT_EQ(read.levels.size(), 2U);
  EXPECT_EQ(read.levels[1].at(1).radius_m, 0.7F);
}

TEST(CapturedShapeBytes, AreRefusedWithTheirRule) {
  const std::string good = shape_bytes(1, some_header().shapes[1]);
  const auto refused = [&](std::string bytes) {
    CapturedShape shape;
    const Status read = read_shape(bytes, 1, shape);
    return read ? std::string("accepted") : read.error().message;
  };
  const auto with = [&](std::size_t at, auto value) {
    std::string part;
    put(value, part);
    return std::string(good).replace(at, part.size(), part);
  };
  EXPECT_EQ(refused(good), "accepted");
  EXPECT_EQ(refused(with(0, 2U)), "SHAP 1: shape = 2, must be 1");
  EXPECT_EQ(refused(with(4, 0xffffffffU)), "SHAP 1: it ends within the triangles");
  EXPECT_EQ(refused(with(12, std::numeric_limits<float>::quiet_NaN())), "SHAP 1: a vertex is not finite");
  EXPECT_EQ(refused(with(12 + 48, 4U)), "SHAP 1: a corner = 4, must be below 4");
  EXPECT_EQ(refused(with(12 + 48 + 48, 8U)), "SHAP 1: levels = 8, must be at most 7");
  EXPECT_EQ(refused(with(12 + 48 + 48 + 4, 9U)), "SHAP 1: it ends within the spheres");
  EXPECT_EQ(refused(with(12 + 48 + 48 + 8 + 12, -1.0F)), "SHAP 1: a sphere is not finite, or its radius below 0");
  EXPECT_EQ(refused(good + "x"), "SHAP 1: its length is not that of its content");
  for (std::size_t size = 0; size < good.size(); ++size) EXPECT_NE(refused(good.substr(0, size)), "accepted") << size;
}

TEST(CapturedBodiesText, GivesBackTheRows) {
  const std::vector<CapturedBody> rows{{3, 1, 0, MotionType::Dynamic, 2.5, "a"},
                                       {7, 2, 0, MotionType::Static, 0, ""},
                                       {9, 0, 0, MotionType::Kinematic, 0, ""}};
  std::vector<CapturedBody> read;
  ASSERT_TRUE(read_bodies(bodies_json(0, std::span(rows).first(1)), some_header(), read).ok());
  ASSERT_TRUE(read_bodies(bodies_json(1, std::span(rows).subspan(1)), some_header(), read).ok());
  EXPECT_EQ(read, rows);
}

TEST(CapturedBodiesText, IsRefusedWithFieldValueAndRule) {
  const auto refused = [](const std::string& json) {
    std::vector<CapturedBody> rows{{5, 0, 0, MotionType::Dynamic, 1, ""}};
    const Status read = read_bodies(json, some_header(), rows);
    return read ? std::string("accepted") : read.error().message;
  };
  const auto row = [](const char* first, const char* number, const char* shape, const char* motion, const char* mass) {
    return std::string("{\"first\":") + first + ",\"number\":" + number + ",\"shape\":" + shape +
           ",\"material\":[0],\"motion\":" + motion + ",\"mass_kg\":" + mass + "}";
  };
  EXPECT_EQ(refused(row("1", "[6]", "[2]", "[2]", "[1]")), "accepted");
  EXPECT_EQ(refused(row("0", "[6]", "[2]", "[2]", "[1]")), "BODY: first = 0, must be a whole number from 1 to 1");
  EXPECT_EQ(refused(row("1", "[5]", "[2]", "[2]", "[1]")), "BODY: number[0]: = 5, must ascend");
  EXPECT_EQ(refused(row("1", "[6]", "[3]", "[2]", "[1]")), "BODY: shape[0] = 3, must be a whole number from 0 to 2");
  EXPECT_EQ(refused(row("1", "[6]", "[2]", "[3]", "[1]")), "BODY: motion[0] = 3, must be a whole number from 0 to 2");
  EXPECT_EQ(refused(row("1", "[6]", "[2]", "[2]", "[1,2]")), "BODY: mass_kg: has 2 items, must have 1");
  EXPECT_EQ(refused(row("1", "[6]", "[2,2]", "[2]", "[1]")), "BODY: shape: has 2 items, must have 1");
  EXPECT_EQ(refused("{").substr(0, 5), "BODY:");
}

TEST(CaptureIndexText, GivesBackTheIndex) {
  const CaptureIndex written{{{100, 0, 60}, {2000, 60, 3}}, {90}, {63, 4, true}};
  const Result<CaptureIndex> read = read_index(index_json(written));
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().blocks.size(), 2U);
  EXPECT_EQ(read.value().blocks[1].at, 2000U);
  EXPECT_EQ(read.value().blocks[1].first_frame, 60U);
  EXPECT_EQ(read.value().blocks[1].frames, 3U);
  EXPECT_EQ(read.value().bodies, std::vector<std::uint64_t>{90});
  EXPECT_EQ(read.value().end.left_out, 4U);
  EXPECT_TRUE(read.value().end.stopped);
  EXPECT_FALSE(
      read_index("{\"blocks\":{\"at\":[1],\"frame\":[],\"frames\":[1]},\"bodies\":[],\"frames\":1,\"left_out\":0,"
                 "\"stopped\":false}")
          .ok());
}

}  // namespace
}  // namespace poise::capture
