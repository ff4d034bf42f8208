// SPDX-License-Identifier: MIT
#include "scene/scene_gaze.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>

#include "assets/files/text_cursor.h"
#include "assets/files/text_file.h"
#include "scene/scene_parse.h"

namespace poise {
namespace io {
namespace {

constexpr Range kGazeTime{0, 1e9, false};
constexpr std::uintmax_t kMostGazeBytes = 64U << 20U;
constexpr std::string_view kGazeColumns = "time_s,x_px,y_px";

/// Also refuses what is not in the image.
void read_gaze_point(const ObjectReader& reader, const SceneCamera& camera, std::array<double, 2>& at_px) {
  const JsonValue* value = reader.require("at_px");
  const SoundSoFar sound(reader.problems());
  reader.pair("at_px", kNotNegative, at_px);
  const auto& size = camera.resolution_px;
  if (value != nullptr && sound && (at_px[0] > size[0] || at_px[1] > size[1])) {
    reader.problems().refuse(reader.path("at_px"), *value,
                             fmt::format("must lie in the image of {:g} x {:g} pixels", size[0], size[1]));
  }
}

void parse_gaze_keys(const ObjectReader& reader, const JsonValue& path, const SceneCamera& camera, SceneGaze& gaze) {
  Problems& problems = reader.problems();
  const std::string place = reader.path("path");
  if (path.kind() != JsonValue::Kind::Array || path.items().empty()) {
    problems.refuse(place, path, "must be a list of at least one key");
    return;
  }
  for (std::size_t i = 0; i < path.items().size(); ++i) {
    const std::string at = item_path(place, i);
    const ObjectReader key(path.items()[i], at, problems, {"time_s", "at_px"});
    const SoundSoFar sound(problems);
    GazeKey read;
    key.require("time_s");
    key.number("time_s", kGazeTime, read.time_s);
    read_gaze_point(key, camera, read.at_px);
    if (i > 0 && sound && !(read.time_s > gaze.path.back().time_s))
      problems.refuse(member_path(at, "time_s"), *path.items()[i].find("time_s"), "must be > that of the key before");
    gaze.path.push_back(read);
  }
}

/// A number of a line, or why it is none.
Result<double> read_gaze_field(std::string_view text, std::string_view field, double most, const std::string& place) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  double value = 0;
  const auto [stop, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || stop != text.data() + text.size() || !std::isfinite(value))
    return bad_input(fmt::format("{}: {} = {}, must be a number", place, field, text.substr(0, 40)));
  if (!(value >= 0 && value <= most))
    return bad_input(fmt::format("{}: {} = {:g}, must be 0 to {:g}", place, field, value, most));
  return value;
}

Result<GazeKey> read_gaze_line(std::string_view line, const std::array<double, 2>& resolution_px,
                               const std::string& place) {
  const auto commas = std::count(line.begin(), line.end(), ',');
  if (commas != 2) return bad_input(fmt::format("{}: has {} fields, must have 3: {}", place, commas + 1, kGazeColumns));
  const std::size_t first = line.find(',');
  const std::size_t second = line.find(',', first + 1);
  const Result<double> time_s = read_gaze_field(line.substr(0, first), "time_s", kGazeTime.max, place);
  if (!time_s) return time_s.error();
  const Result<double> x = read_gaze_field(line.substr(first + 1, second - first - 1), "x_px", resolution_px[0], place);
  if (!x) return x.error();
  const Result<double> y = read_gaze_field(line.substr(second + 1), "y_px", resolution_px[1], place);
  if (!y) return y.error();
  return GazeKey{time_s.value(), {x.value(), y.value()}};
}

Result<std::string> read_gaze_text(const std::filesystem::path& file) {
  return geometry::read_text_file(file, kMostGazeBytes);
}

}  // namespace

void parse_scene_gaze(const JsonValue& value, Problems& problems, Scene& scene) {
  const ObjectReader reader(value, "gaze", problems, {"path", "file", "jumps", "loop"});
  if (value.kind() != JsonValue::Kind::Object) return;
  if (!scene.camera) {
    problems.refuse("gaze", "needs a camera");
    return;
  }
  if (scene.gaze_px) problems.refuse("gaze_px", "not with gaze, which says where the viewer looks");
  SceneGaze gaze;
  const JsonValue* path = reader.find("path");
  const JsonValue* file = reader.find("file");
  if ((path == nullptr) == (file == nullptr)) problems.refuse("gaze", "must have exactly one of path, file");
  if (path != nullptr) parse_gaze_keys(reader, *path, *scene.camera, gaze);
  if (file != nullptr) {
    std::string name;
    reader.text("file", name);
    if (file->kind() == JsonValue::Kind::String && (name.empty() || name.find('\0') != std::string::npos))
      problems.refuse("gaze.file", *file, "must be the name of a file");
    gaze.file = name;
    if (reader.has("jumps")) problems.refuse("gaze.jumps", "not with file, whose points stay until the next");
    gaze.jumps = true;
  } else {
    reader.flag("jumps", gaze.jumps);
  }
  reader.flag("loop", gaze.loop);
  scene.gaze = std::move(gaze);
}

std::optional<std::array<double, 2>> gaze_at(const Scene& scene, double time_s) {
  if (!scene.gaze || scene.gaze->path.empty()) return scene.gaze_px;
  const SceneGaze& gaze = *scene.gaze;
  const double first_s = gaze.path.front().time_s;
  const double last_s = gaze.path.back().time_s;
  if (gaze.loop && time_s > last_s && last_s > first_s)
    time_s = first_s + std::fmod(time_s - first_s, last_s - first_s);
  const auto after = std::upper_bound(gaze.path.begin(), gaze.path.end(), time_s,
                                      [](double t, const GazeKey& key) { return t < key.time_s; });
  if (after == gaze.path.begin()) return gaze.path.front().at_px;
  const GazeKey& a = *(after - 1);
  if (after == gaze.path.end() || gaze.jumps) return a.at_px;
  const double share = (time_s - a.time_s) / (after->time_s - a.time_s);
  return std::array{a.at_px[0] + share * (after->at_px[0] - a.at_px[0]),
                    a.at_px[1] + share * (after->at_px[1] - a.at_px[1])};
}

Result<SceneGaze> read_gaze_file(const std::filesystem::path& file, const std::array<double, 2>& resolution_px) {
  Result<std::string> text = read_gaze_text(file);
  if (!text) return text.error();
  Result<std::vector<GazeKey>> path = parse_gaze(text.value(), file.string(), resolution_px);
  if (!path) return path.error();
  return SceneGaze{std::move(path).value(), true, false, file, std::move(text).value()};
}

}  // namespace io

Result<std::vector<GazeKey>> parse_gaze(std::string_view text, const std::string& name,
                                        const std::array<double, 2>& resolution_px) {
  std::vector<GazeKey> path;
  text = geometry::without_byte_order_mark(text);
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    if (number == 1 && (line == io::kGazeColumns || line == "time,x,y")) continue;
    const std::string place = fmt::format("{}: line {}", name, number);
    const Result<GazeKey> key = io::read_gaze_line(line, resolution_px, place);
    if (!key) return key.error();
    if (!path.empty() && !(key.value().time_s > path.back().time_s)) {
      return bad_input(fmt::format("{}: time_s = {:g}, must be > {:g}, that of the point before", place,
                                   key.value().time_s, path.back().time_s));
    }
    path.push_back(key.value());
  }
  if (path.empty())
    return bad_input(name + ": has no points, must have at least one line of " + std::string(io::kGazeColumns));
  return path;
}

Status read_gaze(Scene& scene) {
  if (!scene.gaze || !scene.gaze->path.empty()) return Done{};
  const std::array<double, 2> resolution_px = scene.camera.value_or(SceneCamera{}).resolution_px;
  Result<SceneGaze> read = io::read_gaze_file(scene.base / scene.gaze->file, resolution_px);
  if (!read) return Error{read.error().kind, scene.source + ": gaze.file: " + read.error().message};
  scene.gaze->path = std::move(read.value().path);
  scene.gaze->text = std::move(read.value().text);
  return Done{};
}

}  // namespace poise
