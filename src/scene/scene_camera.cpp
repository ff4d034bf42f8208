// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "math/functions.h"
#include "scene/scene_gaze.h"
#include "scene/scene_parse.h"

namespace poise {
namespace io {
namespace {

constexpr Range kResolution{1, 1e6, false};
constexpr Range kFieldOfView{0, 179, true};
constexpr Range kTime{0, 1e9, false};
constexpr double kLeastSight = 1e-9;  // m

bool along_sight(const Vec3& up, const Vec3& ahead) {
  return !(up.norm() > kLeastSight) || !(ahead.normalized().cross(up.normalized()).norm() > 1e-6);
}

/// The rules on the values of a camera or of one of its keys together, whose members are at `path`.
void check_sight(const std::string& path, const Vec3& position_m, const Vec3& look_at_m, const Vec3& up,
                 Problems& problems) {
  const Vec3 ahead = look_at_m - position_m;
  if (!(ahead.norm() > kLeastSight)) {
    problems.refuse(member_path(path, "look_at_m"), "must differ from " + member_path(path, "position_m"));
  } else if (along_sight(up, ahead)) {
    problems.refuse("camera.up", "must not be zero, nor along the line of sight" +
                                     (path == "camera" ? std::string() : " of " + path));
  }
}

CameraKey parse_key(const JsonValue& value, const std::string& path, Problems& problems, const SceneCamera& camera) {
  const ObjectReader reader(value, path, problems, {"time_s", "position_m", "look_at_m", "vertical_fov_deg"});
  CameraKey key;
  key.vertical_fov_deg = camera.vertical_fov_deg;
  const SoundSoFar sound(problems);
  for (const char* member : {"time_s", "position_m", "look_at_m"}) reader.require(member);
  reader.number("time_s", kTime, key.time_s);
  reader.vec3("position_m", kAnyQuantity, key.position_m);
  reader.vec3("look_at_m", kAnyQuantity, key.look_at_m);
  reader.number("vertical_fov_deg", kFieldOfView, key.vertical_fov_deg);
  if (sound) check_sight(path, key.position_m, key.look_at_m, camera.up, problems);
  return key;
}

/// A loop must not jump.
void check_loop(const std::string& last, Problems& problems, const std::vector<CameraKey>& keys) {
  const CameraKey& a = keys.front();
  const CameraKey& b = keys.back();
  const std::pair<const char*, bool> members[] = {{"position_m", a.position_m == b.position_m},
                                                  {"look_at_m", a.look_at_m == b.look_at_m},
                                                  {"vertical_fov_deg", a.vertical_fov_deg == b.vertical_fov_deg}};
  for (const auto& [member, same] : members) {
    if (!same) problems.refuse(member_path(last, member), "must be that of the first key, since the path is a loop");
  }
}

void parse_path(const ObjectReader& reader, const JsonValue& path, SceneCamera& camera) {
  Problems& problems = reader.problems();
  for (const char* key : {"position_m", "look_at_m"}) {
    if (reader.has(key)) problems.refuse(reader.path(key), "not with path, whose keys have it");
  }
  const std::string place = reader.path("path");
  if (path.kind() != JsonValue::Kind::Array || path.items().size() < 2) {
    problems.refuse(place, path, "must be a list of at least two keys");
    return;
  }
  const SoundSoFar sound(problems);
  for (std::size_t i = 0; i < path.items().size(); ++i) {
    const std::string at = item_path(place, i);
    const SoundSoFar key_sound(problems);
    camera.path.push_back(parse_key(path.items()[i], at, problems, camera));
    if (i > 0 && key_sound && !(camera.path[i].time_s > camera.path[i - 1].time_s)) {
      problems.refuse(member_path(at, "time_s"), *path.items()[i].find("time_s"), "must be > that of the key before");
    }
  }
  if (sound && camera.loop) check_loop(item_path(place, path.items().size() - 1), problems, camera.path);
  camera.position_m = camera.path.front().position_m;
  camera.look_at_m = camera.path.front().look_at_m;
  camera.vertical_fov_deg = camera.path.front().vertical_fov_deg;
}

/// The keys around a segment's ends: a loop goes on at its other end, and a path without one stands still there.
struct Segment {
  const CameraKey& start;
  const CameraKey& end;
  const CameraKey* before = nullptr;
  const CameraKey* after = nullptr;
  double before_s = 0, after_s = 0;  // their times, beyond the path's ends in a loop
};

Segment segment_of(const SceneCamera& camera, std::size_t i) {
  const std::vector<CameraKey>& path = camera.path;
  Segment segment{path[i], path[i + 1]};
  const double period_s = path.back().time_s - path.front().time_s;
  if (i > 0) {
    segment.before = &path[i - 1];
    segment.before_s = segment.before->time_s;
  } else if (camera.loop) {
    segment.before = &path[path.size() - 2];
    segment.before_s = segment.before->time_s - period_s;
  }
  if (i + 2 < path.size()) {
    segment.after = &path[i + 2];
    segment.after_s = segment.after->time_s;
  } else if (camera.loop) {
    segment.after = &path[1];
    segment.after_s = segment.after->time_s + period_s;
  }
  return segment;
}

Vec3 on_curve(const Segment& s, Vec3 CameraKey::*member, double share) {
  const double long_s = s.end.time_s - s.start.time_s;
  const Vec3& a = s.start.*member;
  const Vec3& b = s.end.*member;
  Vec3 leave = Vec3::Zero();  // tangents, in metres over the segment
  Vec3 arrive = Vec3::Zero();
  if (s.before != nullptr) leave = (b - s.before->*member) * (long_s / (s.end.time_s - s.before_s));
  if (s.after != nullptr) arrive = (s.after->*member - a) * (long_s / (s.after_s - s.start.time_s));
  const double u2 = share * share;
  const double u3 = u2 * share;
  return (2 * u3 - 3 * u2 + 1) * a + (u3 - 2 * u2 + share) * leave + (3 * u2 - 2 * u3) * b + (u3 - u2) * arrive;
}

CameraKey camera_at(const SceneCamera& camera, double time_s) {
  const std::vector<CameraKey>& path = camera.path;
  if (path.empty()) return {time_s, camera.position_m, camera.look_at_m, camera.vertical_fov_deg};
  const double first_s = path.front().time_s;
  const double last_s = path.back().time_s;
  if (camera.loop && time_s > last_s) time_s = first_s + std::fmod(time_s - first_s, last_s - first_s);
  if (time_s <= first_s) return path.front();
  if (time_s >= last_s) return path.back();
  const auto after =
      std::upper_bound(path.begin(), path.end(), time_s, [](double t, const CameraKey& key) { return t < key.time_s; });
  const Segment segment = segment_of(camera, static_cast<std::size_t>(after - path.begin()) - 1);
  const CameraKey& start = segment.start;
  const double share = (time_s - start.time_s) / (segment.end.time_s - start.time_s);
  CameraKey at{time_s, on_curve(segment, &CameraKey::position_m, share),
               on_curve(segment, &CameraKey::look_at_m, share),
               start.vertical_fov_deg + share * (segment.end.vertical_fov_deg - start.vertical_fov_deg)};
  const Vec3 ahead = at.look_at_m - at.position_m;
  if (!(ahead.norm() > kLeastSight) || along_sight(camera.up, ahead))
    at.look_at_m = at.position_m + (start.look_at_m - start.position_m);
  return at;
}

}  // namespace

void parse_camera(const JsonValue& value, Problems& problems, Scene& scene) {
  const ObjectReader reader(value, "camera", problems,
                            {"position_m", "look_at_m", "up", "vertical_fov_deg", "resolution_px", "path", "loop"});
  SceneCamera camera;
  const SoundSoFar sound(problems);
  const JsonValue* path = reader.find("path");
  if (path == nullptr) {
    reader.require("position_m");
    reader.require("look_at_m");
    reader.vec3("position_m", kAnyQuantity, camera.position_m);
    reader.vec3("look_at_m", kAnyQuantity, camera.look_at_m);
  }
  reader.vec3("up", kAnyQuantity, camera.up);
  reader.number("vertical_fov_deg", kFieldOfView, camera.vertical_fov_deg);
  reader.pair("resolution_px", kResolution, camera.resolution_px);
  reader.flag("loop", camera.loop);
  if (path != nullptr) {
    parse_path(reader, *path, camera);
  } else if (camera.loop) {
    problems.refuse("camera.loop", *reader.find("loop"), "needs a path");
  }
  scene.camera = camera;
  if (sound && path == nullptr) check_sight("camera", camera.position_m, camera.look_at_m, camera.up, problems);
}

}  // namespace io

View scene_view(const Scene& scene, double time_s) {
  View view;
  if (!scene.camera) return view;
  const SceneCamera& camera = *scene.camera;
  const CameraKey at = io::camera_at(camera, time_s);
  view.present = true;
  view.position_m = at.position_m;
  view.forward = (at.look_at_m - at.position_m).normalized();
  const Vec3 right = view.forward.cross(camera.up).normalized();
  view.up = right.cross(view.forward).normalized();
  view.vertical_fov_rad = at.vertical_fov_deg * std::numbers::pi / 180;
  const auto [width_px, height_px] = camera.resolution_px;
  view.aspect = width_px / height_px;
  view.gaze = view.forward;
  if (const auto gaze_px = io::gaze_at(scene, time_s)) {
    // The image plane at distance 1: its upper edge is at tan(fov / 2).
    const double half = math::tan(0.5 * view.vertical_fov_rad);
    const double across = (2 * (*gaze_px)[0] / width_px - 1) * half * view.aspect;
    const double upward = (1 - 2 * (*gaze_px)[1] / height_px) * half;
    view.gaze = (view.forward + across * right + upward * view.up).normalized();
  }
  return view;
}

}  // namespace poise
