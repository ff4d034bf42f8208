// SPDX-License-Identifier: MIT
#include "capture/captures.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <utility>

namespace poise::testing {

using capture::CapturedShape;

capture::CaptureHeader some_header(bool contacts) {
  capture::CaptureHeader header;
  header.scene = "a \"scene\"";
  header.command = {"poise", "run", "a scene"};
  header.build = {"1.2.3", "abc", "GNU", "Release"};
  header.machine = {"Linux", "a processor", 8};
  header.dt_s = 1.0 / 64;
  header.deadline_ms = 8;
  header.frames_asked = 100;
  header.gravity_mps2 = {0, 0, -9.81};
  header.policy = "perceptual";
  header.contact = "fitted";
  header.position_step_m = 0.001;
  header.contacts = contacts;
  header.camera = capture::CapturedCamera{{1280, 720}, true};
  header.materials = {{"wood", 0.5, 0.1, 700}};
  CapturedShape ball;
  ball.name = "ball";
  ball.radius_m = 0.5;
  ball.levels = {{{0, 0, 0, 0.5F}}};
  CapturedShape stone;
  stone.name = "stone";
  stone.radius_m = 1;
  stone.vertices_m = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  stone.corners = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  stone.levels = {{{0.25F, 0.25F, 0.25F, 1}}, {{0, 0, 0, 0.5F}, {0.5F, 0.5F, 0, 0.7F}}};
  CapturedShape floor;
  floor.name = "floor";
  floor.plane = true;
  floor.normal = {0, 0, 1};
  header.shapes = {ball, stone, floor};
  return header;
}

std::vector<capture::SeenFrame> some_frames(std::uint64_t seed, std::uint64_t count, std::size_t bodies,
                                            bool contacts) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  std::vector<capture::SeenFrame> frames;
  std::vector<capture::SeenBody> there;
  std::uint64_t number = 0;
  for (std::uint64_t k = 0; k < count; ++k) {
    capture::SeenFrame frame;
    frame.facts.frame = k;
    frame.facts.time_s = static_cast<double>(k) / 64;
    frame.facts.measured = k > 0;
    frame.facts.has_view = true;
    frame.facts.position_m = {10, 0, 5};
    frame.facts.forward = {-1, 0, 0};
    frame.facts.up = {0, 0, 1};
    frame.facts.gaze = {-1, 0, 0};
    frame.facts.vertical_fov_rad = 0.8F;
    frame.facts.aspect = 1.5F;
    frame.facts.times[8] = static_cast<std::uint32_t>(random() % 100000);
    if (k > 0) frame.facts.momentum_ns = {static_cast<float>(k), -0.5F, 1e-9F};
    if (!there.empty() && random() % 4 == 0)
      there.erase(there.begin() + static_cast<std::ptrdiff_t>(random() % there.size()));
    while (there.size() < bodies && (k == 0 || random() % 2 == 0)) {
      capture::CapturedBody row;
      row.number = number;
      row.shape = static_cast<std::uint32_t>(number % 2);
      row.mass_kg = 2.5;
      row.name = number == 0 ? "first" : "";
      frame.new_bodies.push_back(row);
      capture::SeenBody body;
      body.number = number++;
      body.pose.position_m = 5 * Vec3(unit(), unit(), unit());
      there.push_back(body);
    }
    for (capture::SeenBody& body : there) {
      body.activity = static_cast<std::uint8_t>(random() % 8 == 0 ? random() % capture::kActivities : body.activity);
      body.level = static_cast<std::uint8_t>(random() % 8 == 0 ? random() % (kPolygonBin + 2) : body.level);
      body.priority = static_cast<std::uint8_t>(random() % 8 == 0 ? random() : body.priority);
      if (body.number % 3 == 0 || (body.number % 3 == 1 && k / 8 % 2 == 1)) continue;  // rests, or rests for a while
      body.pose.position_m += 0.02 * Vec3(unit(), unit(), unit());
      body.pose.orientation =
          Quat(Quat(1, 0.2 * unit(), 0.2 * unit(), 0.2 * unit()).normalized() * body.pose.orientation).normalized();
    }
    frame.bodies = there;
    for (std::size_t i = 1; contacts && i < there.size(); i += 2) {
      capture::SeenContact& contact = frame.contacts.emplace_back();
      contact.a = there[i - 1].number;
      contact.b = there[i].number;
      contact.level = static_cast<Level>(random() % (kPolygonBin + 1));
      contact.normal = Vec3(unit(), unit(), unit()).normalized();
      contact.point_count = static_cast<std::uint8_t>(1 + random() % 4);
      for (std::size_t point = 0; point < contact.point_count; ++point)
        contact.points_m[point] = there[i].pose.position_m + Vec3(unit(), unit(), unit());
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

std::string written(const std::string& file, const capture::CaptureHeader& header,
                    const std::vector<capture::SeenFrame>& frames, bool stopped) {
  Result<capture::CaptureWriter> writer = capture::CaptureWriter::open(file);
  EXPECT_TRUE(writer.ok());
  EXPECT_TRUE(writer.value().begin(header).ok());
  for (const capture::SeenFrame& frame : frames) writer.value().add(frame);
  EXPECT_TRUE(writer.value().finish(stopped).ok());
  std::ifstream stream(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(bytes.size(), writer.value().bytes());
  return bytes;
}

void put_file(const std::string& file, const std::string& bytes) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace poise::testing
