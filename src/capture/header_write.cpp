// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "capture/bytes.h"
#include "capture/header.h"
#include "capture/packed_pose.h"

namespace poise::capture {
namespace {

using Json = nlohmann::ordered_json;

// Names come from files; what is no UTF-8 in them is replaced.
std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json json_of(const CapturedShape& shape) {
  Json json = {{"name", shape.name},
               {"kind", shape.plane ? "plane" : "tree"},
               {"radius_m", shape.radius_m},
               {"triangles", shape.corners.size() / 3},
               {"levels", shape.levels.size()}};
  if (shape.plane) {
    json["normal"] = shape.normal;
    json["offset_m"] = shape.offset_m;
  }
  return json;
}

}  // namespace

std::string header_json(const CaptureHeader& h) {
  Json materials = Json::array();
  for (const CapturedMaterial& material : h.materials) {
    materials.push_back({{"name", material.name},
                         {"friction", material.friction},
                         {"restitution", material.restitution},
                         {"density_kgpm3", material.density_kgpm3}});
  }
  Json shapes = Json::array();
  for (const CapturedShape& shape : h.shapes) shapes.push_back(json_of(shape));
  Json camera = nullptr;
  if (h.camera) camera = {{"resolution_px", h.camera->resolution_px}, {"moves", h.camera->moves}};
  const Json json = {{"schema", kSchema},
                     {"scene", h.scene},
                     {"command", h.command},
                     {"build", h.build},
                     {"machine", h.machine},
                     {"dt_s", h.dt_s},
                     {"deadline_ms", h.deadline_ms ? Json(*h.deadline_ms) : Json(nullptr)},
                     {"paced", h.paced},
                     {"frames_asked", h.frames_asked ? Json(*h.frames_asked) : Json(nullptr)},
                     {"gravity_mps2", h.gravity_mps2},
                     {"threads", h.threads},
                     {"policy", h.policy},
                     {"contact", h.contact},
                     {"position_step_m", h.position_step_m},
                     {"orientation_steps", h.orientation_steps},
                     {"orientation_error_rad", orientation_error_rad(h.orientation_steps)},
                     {"contacts", h.contacts},
                     {"camera", camera},
                     {"materials", materials},
                     {"shapes", shapes}};
  return text_of(json);
}

std::string shape_bytes(std::uint32_t index, const CapturedShape& shape) {
  std::string out;
  put(index, out);
  put(static_cast<std::uint32_t>(shape.vertices_m.size() / 3), out);
  put(static_cast<std::uint32_t>(shape.corners.size() / 3), out);
  for (const float coordinate : shape.vertices_m) put(coordinate, out);
  for (const std::uint32_t corner : shape.corners) put(corner, out);
  put(static_cast<std::uint32_t>(shape.levels.size()), out);
  for (const std::vector<CapturedSphere>& level : shape.levels) {
    put(static_cast<std::uint32_t>(level.size()), out);
    for (const CapturedSphere& sphere : level) {
      for (const float value : {sphere.x_m, sphere.y_m, sphere.z_m, sphere.radius_m}) put(value, out);
    }
  }
  return out;
}

std::string bodies_json(std::size_t first, std::span<const CapturedBody> bodies) {
  Json number = Json::array(), shape = Json::array(), material = Json::array(), motion = Json::array(),
       mass = Json::array(), name = Json::array();
  bool named = false;
  for (const CapturedBody& body : bodies) {
    number.push_back(body.number);
    shape.push_back(body.shape);
    material.push_back(body.material);
    motion.push_back(static_cast<int>(body.motion));
    mass.push_back(body.mass_kg);
    name.push_back(body.name);
    named = named || !body.name.empty();
  }
  Json json = {{"first", first},       {"number", number}, {"shape", shape},
               {"material", material}, {"motion", motion}, {"mass_kg", mass}};
  if (named) json["name"] = name;
  return text_of(json);
}

std::string index_json(const CaptureIndex& index) {
  Json at = Json::array(), frame = Json::array(), frames = Json::array();
  for (const BlockPlace& block : index.blocks) {
    at.push_back(block.at);
    frame.push_back(block.first_frame);
    frames.push_back(block.frames);
  }
  const Json json = {{"blocks", {{"at", at}, {"frame", frame}, {"frames", frames}}},
                     {"bodies", index.bodies},
                     {"frames", index.end.frames},
                     {"left_out", index.end.left_out},
                     {"stopped", index.end.stopped}};
  return text_of(json);
}

}  // namespace poise::capture
