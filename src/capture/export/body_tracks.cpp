// SPDX-License-Identifier: MIT
#include "capture/export/body_tracks.h"

#include <algorithm>

namespace poise::capture {
namespace {

void add_key(std::uint32_t frame, const PackedPose& pose, BodyKeys& keys) {
  if (keys.frame.empty()) {
    keys.first = frame;
  } else if (pose == keys.pose.back()) {
    keys.last = frame;
    return;
  } else if (keys.last > keys.frame.back()) {
    // It rested until the frame before.
    keys.frame.push_back(keys.last);
    keys.pose.push_back(PackedPose(keys.pose.back()));
  }
  keys.frame.push_back(frame);
  keys.pose.push_back(pose);
  keys.last = frame;
}

Vec3 vector_of(const std::array<float, 3>& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

CameraKey camera_of(const FrameFacts& facts) {
  CameraKey key;
  key.position_m = {facts.position_m[0], facts.position_m[1], facts.position_m[2]};
  const Vec3 forward = vector_of(facts.forward).normalized();
  const Vec3 right = forward.cross(vector_of(facts.up)).normalized();
  Mat3 axes;
  axes.col(0) = right;
  axes.col(1) = right.cross(forward);
  axes.col(2) = -forward;
  if (axes.allFinite()) key.orientation = Quat(axes).normalized();
  key.vertical_fov_rad = static_cast<double>(facts.vertical_fov_rad);
  key.aspect = static_cast<double>(facts.aspect);
  return key;
}

}  // namespace

Result<BodyTracks> body_tracks(CaptureReader& reader, const FrameChoice& choice, const std::function<bool()>& goes_on) {
  BodyTracks tracks;
  tracks.bodies.resize(reader.bodies().size());
  double first_s = 0;
  const Status read = read_chosen(reader, choice, [&](const PackedFrame& frame) {
    if (tracks.time_s.empty()) first_s = frame.facts.time_s;
    const auto index = static_cast<std::uint32_t>(tracks.time_s.size());
    tracks.time_s.push_back(frame.facts.time_s - first_s);
    for (std::size_t i = 0; i < frame.rows.size(); ++i) {
      add_key(index, frame.poses[i], tracks.bodies[frame.rows[i]]);
      const CapturedBody& body = reader.bodies()[frame.rows[i]];
      if (body.motion == MotionType::Static) continue;
      const double radius_m = reader.header().shapes[body.shape].radius_m;
      tracks.reach_m = std::max(tracks.reach_m, reader.pose(frame.poses[i]).position_m.norm() + radius_m);
    }
    if (frame.facts.has_view && tracks.camera.size() == index) tracks.camera.push_back(camera_of(frame.facts));
    return !goes_on || goes_on();
  });
  if (!read) return read.error();
  if (tracks.camera.size() != tracks.time_s.size()) tracks.camera.clear();
  for (BodyKeys& keys : tracks.bodies) {
    if (!keys.frame.empty() && keys.last > keys.frame.back()) {
      keys.frame.push_back(keys.last);
      keys.pose.push_back(PackedPose(keys.pose.back()));
    }
  }
  return tracks;
}

}  // namespace poise::capture
