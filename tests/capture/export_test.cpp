// SPDX-License-Identifier: MIT
#include <assimp/scene.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>

#include "capture/captures.h"
#include "capture/export/drawn_mesh.h"
#include "capture/export/figures_csv.h"
#include "capture/export/gltf.h"
#include "capture/export/paraview.h"
#include "scene/temporary_folder.h"

namespace poise::capture {
namespace {

using testing::some_frames;
using testing::some_header;
using testing::TemporaryFolder;
using testing::written;

CaptureReader reader_of(const TemporaryFolder& folder, std::uint64_t frames, std::size_t bodies = 6) {
  written(folder.file("a"), some_header(), some_frames(21, frames, bodies));
  Result<CaptureReader> reader = CaptureReader::open(folder.file("a"));
  EXPECT_TRUE(reader.ok());
  return std::move(reader).value();
}

const aiScene* imported(Assimp::Importer& importer, const std::string& glb) {
  const aiScene* scene = importer.ReadFileFromMemory(glb.data(), glb.size(), 0, "glb");
  EXPECT_NE(scene, nullptr) << importer.GetErrorString();
  return scene;
}

/// Position of a channel at a time, linear between its keys.
aiVector3D position_at(const aiNodeAnim& channel, double time) {
  for (unsigned k = 0; k + 1 < channel.mNumPositionKeys; ++k) {
    const aiVectorKey& a = channel.mPositionKeys[k];
    const aiVectorKey& b = channel.mPositionKeys[k + 1];
    if (time > b.mTime) continue;
    const auto share = static_cast<ai_real>(std::clamp((time - a.mTime) / (b.mTime - a.mTime), 0.0, 1.0));
    return a.mValue + (b.mValue - a.mValue) * share;
  }
  return channel.mPositionKeys[channel.mNumPositionKeys - 1].mValue;
}

TEST(Gltf, OfOneFrameHasANodeForEachBodyWhereItIs) {
  const TemporaryFolder folder;
  CaptureReader reader = reader_of(folder, 100);
  const Result<std::string> glb = gltf_bytes(reader, {70, 70, 1});
  ASSERT_TRUE(glb.ok()) << glb.error().message;
  Assimp::Importer importer;
  const aiScene* scene = imported(importer, glb.value());
  ASSERT_NE(scene, nullptr);
  EXPECT_EQ(scene->mNumAnimations, 0U);
  EXPECT_EQ(scene->mNumMeshes, 2U) << "a ball and a stone; no body is the floor";
  EXPECT_EQ(scene->mNumCameras, 1U);
  PackedFrame frame;
  ASSERT_TRUE(reader.read_frames(70, 70, [&](const PackedFrame& read) {
    frame = read;
    return true;
  }));
  ASSERT_FALSE(frame.rows.empty());
  for (std::size_t i = 0; i < frame.rows.size(); ++i) {
    const aiNode* node = scene->mRootNode->FindNode(body_name(reader, frame.rows[i]).c_str());
    ASSERT_NE(node, nullptr) << body_name(reader, frame.rows[i]);
    EXPECT_EQ(node->mNumMeshes, 1U);
    aiVector3D scale, position;
    aiQuaternion turn;
    node->mTransformation.Decompose(scale, turn, position);
    const Pose pose = reader.pose(frame.poses[i]);
    EXPECT_NEAR(position.x, pose.position_m.x(), 1e-5);
    EXPECT_NEAR(position.z, pose.position_m.z(), 1e-5);
    const Quat read(static_cast<double>(turn.w), static_cast<double>(turn.x), static_cast<double>(turn.y),
                    static_cast<double>(turn.z));
    EXPECT_LT(read.angularDistance(pose.orientation), 1e-3);
  }
}

TEST(Gltf, OfARunMovesEachBodyAsTheCaptureDoes) {
  const TemporaryFolder folder;
  CaptureReader reader = reader_of(folder, 90);
  const Result<std::string> glb = gltf_bytes(reader, {});
  ASSERT_TRUE(glb.ok());
  Assimp::Importer importer;
  const aiScene* scene = imported(importer, glb.value());
  ASSERT_NE(scene, nullptr);
  ASSERT_EQ(scene->mNumAnimations, 1U);
  const aiAnimation& animation = *scene->mAnimations[0];
  std::map<std::string, const aiNodeAnim*> channels;
  for (unsigned i = 0; i < animation.mNumChannels; ++i)
    channels[animation.mChannels[i]->mNodeName.C_Str()] = animation.mChannels[i];
  std::size_t compared = 0;
  ASSERT_TRUE(reader.read_frames(0, 1000, [&](const PackedFrame& frame) {
    for (std::size_t i = 0; i < frame.rows.size(); ++i) {
      const auto found = channels.find(body_name(reader, frame.rows[i]));
      if (found == channels.end() || found->second->mNumPositionKeys < 2) continue;
      const double ticks = animation.mTicksPerSecond > 0 ? animation.mTicksPerSecond : 1000;
      const aiVector3D at = position_at(*found->second, frame.facts.time_s * ticks);
      const Vec3 expected = reader.pose(frame.poses[i]).position_m;
      EXPECT_NEAR(at.x, expected.x(), 1e-4) << frame.facts.frame;
      EXPECT_NEAR(at.y, expected.y(), 1e-4);
      EXPECT_NEAR(at.z, expected.z(), 1e-4);
      ++compared;
    }
    return !::testing::Test::HasFailure();
  }));
  EXPECT_GT(compared, 200U);
}

TEST(Gltf, HasNoSizeForABodyBeforeItComesAndAfterItLeaves) {
  const TemporaryFolder folder;
  CaptureReader reader = reader_of(folder, 90);
  const Result<BodyTracks> tracks = body_tracks(reader, {});
  ASSERT_TRUE(tracks.ok());
  Assimp::Importer importer;
  const Result<std::string> glb = gltf_bytes(reader, {});
  const aiScene* scene = imported(importer, glb.value());
  ASSERT_NE(scene, nullptr);
  std::map<std::string, const aiNodeAnim*> channels;
  for (unsigned i = 0; i < scene->mAnimations[0]->mNumChannels; ++i)
    channels[scene->mAnimations[0]->mChannels[i]->mNodeName.C_Str()] = scene->mAnimations[0]->mChannels[i];
  std::size_t came_and_left = 0;
  for (std::uint32_t row = 0; row < tracks.value().bodies.size(); ++row) {
    const BodyKeys& keys = tracks.value().bodies[row];
    if (keys.frame.empty() || keys.first == 0 || keys.last == 89) continue;
    ++came_and_left;
    const aiNodeAnim* channel = channels[body_name(reader, row)];
    ASSERT_NE(channel, nullptr);
    ASSERT_EQ(channel->mNumScalingKeys, 3U);
    EXPECT_EQ(channel->mScalingKeys[0].mValue.x, 0);
    EXPECT_EQ(channel->mScalingKeys[1].mValue.x, 1);
    EXPECT_EQ(channel->mScalingKeys[2].mValue.x, 0);
  }
  EXPECT_GT(came_and_left, 0U);
}

TEST(BodyTracks, GiveEveryPoseByLinearInterpolation) {
  const TemporaryFolder folder;
  CaptureReader reader = reader_of(folder, 80);
  const Result<BodyTracks> tracks = body_tracks(reader, {0, 1000, 3});
  ASSERT_TRUE(tracks.ok());
  EXPECT_EQ(tracks.value().time_s.size(), 27U);
  std::size_t kept = 0;
  std::uint32_t index = 0;
  ASSERT_TRUE(read_chosen(reader, {0, 1000, 3}, [&](const PackedFrame& frame) {
    for (std::size_t i = 0; i < frame.rows.size(); ++i) {
      const BodyKeys& keys = tracks.value().bodies[frame.rows[i]];
      const auto after = std::ranges::lower_bound(keys.frame, index) - keys.frame.begin();
      const auto at = static_cast<std::size_t>(after);
      EXPECT_LT(at, keys.frame.size());
      EXPECT_EQ(keys.pose[at], frame.poses[i]);
      if (keys.frame[at] == index) {
        ++kept;
      } else {
        EXPECT_EQ(keys.pose[at - 1], frame.poses[i]) << "it rests between the two keys";
      }
    }
    ++index;
    return true;
  }));
  EXPECT_GT(kept, 0U);
}

TEST(DrawnMesh, OfABallHasItsVerticesOnItAndItsTrianglesOutward) {
  const CapturedShape ball = some_header().shapes[0];
  const DrawnMesh mesh = drawn_mesh(ball, 1);
  EXPECT_EQ(mesh.triangles.size(), 320U);
  EXPECT_EQ(mesh.vertices_m.size(), 162U) << "Euler: V = 2 + F / 2";
  const auto vertex = [&](std::uint32_t i) {
    return Vec3(static_cast<double>(mesh.vertices_m[i][0]), static_cast<double>(mesh.vertices_m[i][1]),
                static_cast<double>(mesh.vertices_m[i][2]));
  };
  for (std::uint32_t i = 0; i < mesh.vertices_m.size(); ++i) EXPECT_NEAR(vertex(i).norm(), 0.5, 1e-6);
  for (const auto& [a, b, c] : mesh.triangles)
    EXPECT_GT((vertex(b) - vertex(a)).cross(vertex(c) - vertex(a)).dot(vertex(a)), 0);
}

TEST(DrawnMesh, OfAPlaneFacesAwayFromItsSolidSide) {
  CapturedShape plane = some_header().shapes[2];
  plane.normal = {0.6, 0, 0.8};
  plane.offset_m = 2;
  const DrawnMesh mesh = drawn_mesh(plane, 10);
  ASSERT_EQ(mesh.triangles.size(), 2U);
  const Vec3 normal(0.6, 0, 0.8);
  std::vector<Vec3> v;
  for (const std::array<float, 3>& vertex : mesh.vertices_m) {
    v.emplace_back(static_cast<double>(vertex[0]), static_cast<double>(vertex[1]), static_cast<double>(vertex[2]));
    EXPECT_NEAR(normal.dot(v.back()), 2, 1e-5);
  }
  for (const auto& [a, b, c] : mesh.triangles) EXPECT_GT((v[b] - v[a]).cross(v[c] - v[a]).dot(normal), 0);
}

TEST(Paraview, FilesHaveAsManyBytesAsTheyState) {
  const TemporaryFolder folder;
  CaptureReader reader = reader_of(folder, 3);
  FrameDrawer drawer(reader);
  ASSERT_TRUE(reader.read_frames(0, 9, [&](const PackedFrame& frame) {
    const std::string vtp = drawer.vtp(frame);
    EXPECT_NE(vtp.find("NumberOfPoints=\"" + std::to_string(frame.rows.size()) + "\""), std::string::npos);
    const std::size_t data = vtp.find("encoding=\"raw\">\n_") + 17;
    // Arrays follow on each other, each behind its size.
    std::size_t at = 0;
    for (std::size_t found = vtp.find("offset=\""); found != std::string::npos;
         found = vtp.find("offset=\"", found + 1)) {
      EXPECT_EQ(std::stoull(vtp.substr(found + 8)), at);
      std::uint64_t size = 0;
      vtp.copy(reinterpret_cast<char*>(&size), 8, data + at);
      at += 8 + size;
    }
    EXPECT_EQ(vtp.substr(data + at), "\n</AppendedData>\n</VTKFile>\n");
    return true;
  }));
  EXPECT_NE(shape_vtp(some_header().shapes[1], 1).find("NumberOfPolys=\"4\""), std::string::npos);
  EXPECT_NE(pvd({{0.5, "frame-000032.vtp"}}).find("<DataSet timestep=\"0.5\" part=\"0\" file=\"frame-000032.vtp\"/>"),
            std::string::npos);
}

TEST(FiguresCsv, HasACellForEachColumn) {
  const TemporaryFolder folder;
  CaptureReader reader = reader_of(folder, 3);
  const std::vector<std::string> names = testing::cells(figures_header().substr(0, figures_header().size() - 1));
  ASSERT_TRUE(reader.read_frames(0, 9, [&](const PackedFrame& frame) {
    const std::string row = figures_row(frame);
    const std::vector<std::string> values = testing::cells(row.substr(0, row.size() - 1));
    EXPECT_EQ(values.size(), names.size());
    EXPECT_EQ(values[0], std::to_string(frame.facts.frame));
    const auto total = static_cast<std::size_t>(std::ranges::find(names, "total_ms") - names.begin());
    EXPECT_EQ(values[total].empty(), frame.facts.frame == 0) << "the start was not measured";
    return true;
  }));
}

TEST(Export, OfFramesThatAreNotThereIsRefused) {
  const TemporaryFolder folder;
  CaptureReader reader = reader_of(folder, 3);
  const Result<std::string> none = gltf_bytes(reader, {7, 9, 1});
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().message, folder.file("a") + ": has no frame from 7 up to 9");
}

}  // namespace
}  // namespace poise::capture
