// SPDX-License-Identifier: MIT
#include "app/picture/drawn_frame.h"

#include <cstddef>

#include "capture/observe.h"

namespace poise::io {
namespace {

Vec3 against(const Vec3& gravity) { return gravity.norm() > 0 ? Vec3(-gravity.normalized()) : Vec3(Vec3::UnitZ()); }

DrawnBody drawn_body(std::uint32_t shape, const capture::Pose& pose, MotionType motion, std::uint8_t activity,
                     std::uint8_t level) {
  DrawnBody body{shape, pose, motion != MotionType::Dynamic, {}};
  // A run that is drawn at its end knows no level of a body that fell asleep before, so a capture's is not shown.
  const bool asleep = activity == static_cast<std::uint8_t>(capture::BodyActivity::Asleep);
  if (level > 0 && !asleep) body.level = static_cast<Level>(level - 1);
  return body;
}

Vec3 vector_of(const std::array<float, 3>& v) {
  return Vec3(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
}

}  // namespace

Result<DrawnFrame> drawn_frame(const Scene& scene, SceneRun& run, std::uint64_t frame, double time_s) {
  capture::SeenFrame seen;
  const Status observed = capture::FrameObserver(scene, run, false).observe(seen);
  if (!observed) return observed.error();
  DrawnFrame drawn;
  drawn.scene = scene.name;
  drawn.frame = frame;
  drawn.time_s = time_s;
  drawn.view = run.view();
  if (scene.camera) drawn.resolution_px = scene.camera->resolution_px;
  drawn.up = against(scene.gravity_mps2);
  const std::span<const RunBody> bodies = run.bodies();
  for (std::size_t i = 0; i < seen.bodies.size(); ++i) {
    const capture::SeenBody& body = seen.bodies[i];
    drawn.bodies.push_back(drawn_body(static_cast<std::uint32_t>(bodies[i].shape), body.pose, bodies[i].motion,
                                      body.activity, body.level));
  }
  return drawn;
}

DrawnFrame drawn_frame(const capture::CaptureReader& reader, const capture::PackedFrame& frame) {
  const capture::CaptureHeader& header = reader.header();
  DrawnFrame drawn;
  drawn.scene = header.scene;
  drawn.frame = frame.facts.frame;
  drawn.time_s = frame.facts.time_s;
  const capture::FrameFacts& facts = frame.facts;
  drawn.view.present = facts.has_view;
  if (facts.has_view) {
    drawn.view.position_m = Vec3(facts.position_m[0], facts.position_m[1], facts.position_m[2]);
    drawn.view.forward = vector_of(facts.forward).normalized();
    drawn.view.up = vector_of(facts.up).normalized();
    drawn.view.gaze = vector_of(facts.gaze).normalized();
    drawn.view.vertical_fov_rad = static_cast<double>(facts.vertical_fov_rad);
    drawn.view.aspect = static_cast<double>(facts.aspect);
  }
  if (header.camera) drawn.resolution_px = header.camera->resolution_px;
  drawn.up = against(Vec3(header.gravity_mps2[0], header.gravity_mps2[1], header.gravity_mps2[2]));
  for (std::size_t i = 0; i < frame.rows.size(); ++i) {
    const capture::CapturedBody& row = reader.bodies()[frame.rows[i]];
    drawn.bodies.push_back(
        drawn_body(row.shape, reader.pose(frame.poses[i]), row.motion, frame.activity[i], frame.level[i]));
  }
  return drawn;
}

}  // namespace poise::io
