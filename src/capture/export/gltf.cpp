// SPDX-License-Identifier: MIT
#include "capture/export/gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>

#include "capture/bytes.h"
#include "capture/export/drawn_mesh.h"

namespace poise::capture {
namespace {

using Json = nlohmann::ordered_json;

// Of the standard (Khronos, "glTF 2.0 Specification").
constexpr std::uint32_t kGlbMagic = 0x46546C67, kGlbVersion = 2, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsigned = 5125, kArrayBuffer = 34962, kIndexBuffer = 34963;

constexpr std::array<std::array<double, 3>, 8> kColors{{{0.27, 0.51, 0.71},
                                                        {0.85, 0.54, 0.31},
                                                        {0.42, 0.66, 0.36},
                                                        {0.79, 0.64, 0.15},
                                                        {0.55, 0.39, 0.69},
                                                        {0.36, 0.66, 0.68},
                                                        {0.77, 0.40, 0.49},
                                                        {0.58, 0.50, 0.42}}};
constexpr std::array<double, 3> kPlaneColor{0.75, 0.75, 0.75};

/// The binary part and what the JSON says of it. Invariant: views and accessors are within `bytes`.
class Buffer {
 public:
  std::string bytes;
  Json views = Json::array(), accessors = Json::array();

  /// All of `values`, `width` to an element, as an accessor; `target` 0 for none.
  template <class T>
  std::size_t add(const std::vector<T>& values, int width, int target, bool with_range) {
    static_assert(sizeof(T) == 4);
    Json view = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", 4 * values.size()}};
    if (target != 0) view["target"] = target;
    Json accessor = {{"bufferView", views.size()},
                     {"componentType", std::is_same_v<T, float> ? kFloat : kUnsigned},
                     {"count", values.size() / static_cast<std::size_t>(width)},
                     {"type", width == 1   ? "SCALAR"
                              : width == 3 ? "VEC3"
                                           : "VEC4"}};
    if (with_range) {
      Json least = Json::array(), most = Json::array();
      for (int part = 0; part < width; ++part) {
        T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest();
        for (std::size_t i = static_cast<std::size_t>(part); i < values.size(); i += static_cast<std::size_t>(width)) {
          low = std::min(low, values[i]);
          high = std::max(high, values[i]);
        }
        least.push_back(low);
        most.push_back(high);
      }
      accessor["min"] = least;
      accessor["max"] = most;
    }
    for (const T value : values) put(value, bytes);
    views.push_back(std::move(view));
    accessors.push_back(std::move(accessor));
    return accessors.size() - 1;
  }
};

/// Builds the document. Invariant: every index in it is of something that is there.
class Document {
 public:
  explicit Document(const CaptureReader& reader, const BodyTracks& tracks) : reader_(reader), tracks_(tracks) {}

  std::string made() {
    // A quarter turn about x.
    const double half = std::sqrt(0.5);
    nodes_.push_back({{"name", "scene"}, {"rotation", {-half, 0, 0, half}}, {"children", Json::array()}});
    for (std::uint32_t row = 0; row < tracks_.bodies.size(); ++row) {
      if (!tracks_.bodies[row].frame.empty()) add_body(row);
    }
    if (!tracks_.camera.empty()) add_camera();
    return bytes();
  }

 private:
  void add_shape(std::uint32_t index) {
    if (meshes_of_.empty()) meshes_of_.assign(reader_.header().shapes.size(), kNone);
    if (meshes_of_[index] != kNone) return;
    const CapturedShape& shape = reader_.header().shapes[index];
    // Nothing is seen of a scene without moving bodies but squares of this size.
    const DrawnMesh mesh = drawn_mesh(shape, 1.2 * tracks_.reach_m);
    if (mesh.triangles.empty()) return;
    std::vector<float> vertices;
    for (const std::array<float, 3>& vertex : mesh.vertices_m)
      vertices.insert(vertices.end(), vertex.begin(), vertex.end());
    std::vector<std::uint32_t> corners;
    for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles)
      corners.insert(corners.end(), triangle.begin(), triangle.end());
    const std::size_t positions = buffer_.add(vertices, 3, kArrayBuffer, true);
    const std::size_t indices = buffer_.add(corners, 1, kIndexBuffer, true);
    const std::array<double, 3> color = shape.plane ? kPlaneColor : kColors[index % kColors.size()];
    materials_.push_back(
        {{"name", shape.name},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {color[0], color[1], color[2], 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.7}}}});
    meshes_of_[index] = meshes_.size();
    meshes_.push_back(
        {{"name", shape.name},
         {"primitives",
          {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", materials_.size() - 1}}}}});
  }

  void add_body(std::uint32_t row) {
    const CapturedBody& body = reader_.bodies()[row];
    add_shape(body.shape);
    const BodyKeys& keys = tracks_.bodies[row];
    std::vector<float> positions, orientations;
    Quat before = Quat::Identity();
    for (const PackedPose& packed : keys.pose) {
      Pose pose = reader_.pose(packed);
      // The nearer of the two quaternions of an orientation, so that interpolation takes the short way.
      if (before.dot(pose.orientation) < 0) pose.orientation.coeffs() = -pose.orientation.coeffs();
      before = pose.orientation;
      append(pose.position_m, positions);
      append(pose.orientation, orientations);
    }
    Json node = {{"name", body_name(reader_, row)},
                 {"translation", {positions[0], positions[1], positions[2]}},
                 {"rotation", {orientations[0], orientations[1], orientations[2], orientations[3]}},
                 {"extras", {{"number", body.number}}}};
    if (meshes_of_[body.shape] != kNone) node["mesh"] = meshes_of_[body.shape];
    const std::size_t index = add_node(std::move(node));
    if (keys.frame.size() > 2 || (keys.frame.size() == 2 && keys.pose[0] != keys.pose[1])) {
      const std::size_t times = times_of(keys.frame);
      add_channel(index, "translation", times, buffer_.add(positions, 3, 0, false), "LINEAR");
      add_channel(index, "rotation", times, buffer_.add(orientations, 4, 0, false), "LINEAR");
    }
    add_presence(index, keys);
  }

  /// A body that comes or leaves has no size before and after.
  void add_presence(std::size_t node, const BodyKeys& keys) {
    const auto frames = static_cast<std::uint32_t>(tracks_.time_s.size());
    std::vector<std::uint32_t> at;
    std::vector<float> scale;
    const auto key = [&](std::uint32_t frame, float size) {
      at.push_back(frame);
      scale.insert(scale.end(), 3, size);
    };
    if (keys.first > 0) key(0, 0);
    if (keys.first > 0 || keys.last + 1 < frames) key(keys.first, 1);
    if (keys.last + 1 < frames) key(keys.last + 1, 0);
    if (!at.empty()) add_channel(node, "scale", times_of(at), buffer_.add(scale, 3, 0, false), "STEP");
  }

  void add_camera() {
    const CameraKey& first = tracks_.camera.front();
    std::vector<float> positions, orientations;
    std::vector<std::uint32_t> frames;
    Quat before = first.orientation;
    for (std::size_t i = 0; i < tracks_.camera.size(); ++i) {
      Quat turned = tracks_.camera[i].orientation;
      if (before.dot(turned) < 0) turned.coeffs() = -turned.coeffs();
      before = turned;
      frames.push_back(static_cast<std::uint32_t>(i));
      append(tracks_.camera[i].position_m, positions);
      append(turned, orientations);
    }
    cameras_.push_back({{"type", "perspective"},
                        {"perspective",
                         {{"yfov", first.vertical_fov_rad},
                          {"aspectRatio", first.aspect},
                          {"znear", 1e-3 * std::max(1.0, tracks_.reach_m)}}}});
    const std::size_t node =
        add_node({{"name", "camera"},
                  {"camera", 0},
                  {"translation", {positions[0], positions[1], positions[2]}},
                  {"rotation", {orientations[0], orientations[1], orientations[2], orientations[3]}}});
    const bool moves = std::ranges::any_of(tracks_.camera, [&](const CameraKey& key) {
      return key.position_m != first.position_m || key.orientation.coeffs() != first.orientation.coeffs();
    });
    if (!moves) return;
    const std::size_t times = times_of(frames);
    add_channel(node, "translation", times, buffer_.add(positions, 3, 0, false), "LINEAR");
    add_channel(node, "rotation", times, buffer_.add(orientations, 4, 0, false), "LINEAR");
  }

  std::size_t add_node(Json node) {
    nodes_[0]["children"].push_back(nodes_.size());
    nodes_.push_back(std::move(node));
    return nodes_.size() - 1;
  }

  void add_channel(std::size_t node, const char* path, std::size_t times, std::size_t values,
                   const char* interpolation) {
    channels_.push_back({{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", path}}}});
    samplers_.push_back({{"input", times}, {"output", values}, {"interpolation", interpolation}});
  }

  /// Most bodies that move have keys at all frames, which are stored once.
  std::size_t times_of(const std::vector<std::uint32_t>& frames) {
    const bool all = frames.size() == tracks_.time_s.size();
    if (all && all_times_ != kNone) return all_times_;
    std::vector<float> times;
    for (const std::uint32_t frame : frames) times.push_back(static_cast<float>(tracks_.time_s[frame]));
    const std::size_t made = buffer_.add(times, 1, 0, true);
    if (all) all_times_ = made;
    return made;
  }

  static void append(const Vec3& v, std::vector<float>& out) {
    for (const double part : v) out.push_back(static_cast<float>(part));
  }
  static void append(const Quat& q, std::vector<float>& out) {
    for (const double part : {q.x(), q.y(), q.z(), q.w()}) out.push_back(static_cast<float>(part));
  }

  std::string bytes() {
    Json json = {{"asset", {{"version", "2.0"}, {"generator", "poise export"}}},
                 {"scene", 0},
                 {"scenes", {{{"name", reader_.header().scene}, {"nodes", {0}}}}},
                 {"nodes", nodes_}};
    // Empty arrays are not allowed.
    const auto add = [&](const char* key, const Json& list) {
      if (!list.empty()) json[key] = list;
    };
    add("meshes", meshes_);
    add("materials", materials_);
    add("cameras", cameras_);
    if (!channels_.empty()) json["animations"] = {{{"name", "run"}, {"channels", channels_}, {"samplers", samplers_}}};
    add("bufferViews", buffer_.views);
    add("accessors", buffer_.accessors);
    if (!buffer_.bytes.empty()) json["buffers"] = {{{"byteLength", buffer_.bytes.size()}}};
    std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string glb;
    const std::size_t binary = buffer_.bytes.empty() ? 0 : 8 + buffer_.bytes.size();
    put(kGlbMagic, glb);
    put(kGlbVersion, glb);
    put(static_cast<std::uint32_t>(20 + text.size() + binary), glb);
    put(static_cast<std::uint32_t>(text.size()), glb);
    put(kJsonChunk, glb);
    glb += text;
    if (binary == 0) return glb;
    put(static_cast<std::uint32_t>(buffer_.bytes.size()), glb);
    put(kBinaryChunk, glb);
    return glb + buffer_.bytes;
  }

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  const CaptureReader& reader_;
  const BodyTracks& tracks_;
  Buffer buffer_;
  Json nodes_ = Json::array(), meshes_ = Json::array(), materials_ = Json::array(), cameras_ = Json::array(),
       channels_ = Json::array(), samplers_ = Json::array();
  std::vector<std::size_t> meshes_of_;  // one a shape
  std::size_t all_times_ = kNone;
};

}  // namespace

Result<std::string> gltf_bytes(CaptureReader& reader, const FrameChoice& choice, const std::function<bool()>& goes_on) {
  const Result<BodyTracks> tracks = body_tracks(reader, choice, goes_on);
  if (!tracks) return tracks.error();
  if (goes_on && !goes_on()) return std::string();
  std::string glb = Document(reader, tracks.value()).made();
  if (glb.size() > std::numeric_limits<std::uint32_t>::max())
    return bad_input(reader.name() + ": gives more than the 4 GiB that a .glb may have; choose fewer frames");
  return glb;
}

}  // namespace poise::capture
