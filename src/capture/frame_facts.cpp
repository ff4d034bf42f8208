// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>

#include "capture/frame_code.h"

namespace poise::capture {
namespace {

constexpr std::uint8_t kMeasured = 1, kWarmUp = 2, kHasView = 4;

template <class Array>
void put_all(const Array& values, std::string& out) {
  for (const auto value : values) put(value, out);
}

template <class Array>
void get_all(ByteReader& bytes, Array& values) {
  for (auto& value : values) value = bytes.get<typename Array::value_type>();
}

template <class Array>
bool finite(const Array& values) {
  for (const auto value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

}  // namespace

void put_facts(const FrameFacts& facts, std::string& out) {
  put(facts.frame, out);
  put(facts.time_s, out);
  put(facts.left_out, out);
  put(static_cast<std::uint8_t>((facts.measured ? kMeasured : 0) | (facts.warm_up ? kWarmUp : 0) |
                                (facts.has_view ? kHasView : 0)),
      out);
  put(static_cast<std::uint8_t>(facts.cause), out);
  put(std::uint16_t{0}, out);
  put_all(facts.position_m, out);
  put_all(facts.forward, out);
  put_all(facts.up, out);
  put_all(facts.gaze, out);
  put(facts.vertical_fov_rad, out);
  put(facts.aspect, out);
  put_all(facts.gaze_px, out);
  put_all(facts.times, out);
  put(facts.budget, out);
  put(facts.reserve, out);
  put(facts.lateness, out);
  put_all(facts.counts, out);
  put_all(facts.levels, out);
  put(facts.work, out);
  put(facts.kinetic_j, out);
  put(facts.potential_j, out);
}

Status get_facts(ByteReader& bytes, FrameFacts& facts) {
  facts.frame = bytes.get<std::uint64_t>();
  facts.time_s = bytes.get<double>();
  facts.left_out = bytes.get<std::uint32_t>();
  const auto flags = bytes.get<std::uint8_t>();
  const auto cause = bytes.get<std::uint8_t>();
  const auto reserved = bytes.get<std::uint16_t>();
  get_all(bytes, facts.position_m);
  get_all(bytes, facts.forward);
  get_all(bytes, facts.up);
  get_all(bytes, facts.gaze);
  facts.vertical_fov_rad = bytes.get<float>();
  facts.aspect = bytes.get<float>();
  get_all(bytes, facts.gaze_px);
  get_all(bytes, facts.times);
  facts.budget = bytes.get<std::uint32_t>();
  facts.reserve = bytes.get<std::uint32_t>();
  facts.lateness = bytes.get<std::uint32_t>();
  get_all(bytes, facts.counts);
  get_all(bytes, facts.levels);
  facts.work = bytes.get<std::uint64_t>();
  facts.kinetic_j = bytes.get<double>();
  facts.potential_j = bytes.get<double>();
  if (!bytes.sound()) return bad_input("it ends within the fixed part of a frame");
  if (!std::isfinite(facts.time_s)) return bad_input("time_s is not finite");
  if (flags > (kMeasured | kWarmUp | kHasView)) return bad_input(fmt::format("flags = {}, must be at most 7", flags));
  if (cause > static_cast<std::uint8_t>(MissCause::Release))
    return bad_input(fmt::format("cause = {}, must be at most 5", cause));
  if (reserved != 0) return bad_input(fmt::format("reserved = {}, must be 0", reserved));
  facts.measured = (flags & kMeasured) != 0;
  facts.warm_up = (flags & kWarmUp) != 0;
  facts.has_view = (flags & kHasView) != 0;
  facts.cause = static_cast<MissCause>(cause);
  const bool view_sound = finite(facts.position_m) && finite(facts.forward) && finite(facts.up) && finite(facts.gaze) &&
                          finite(facts.gaze_px) && std::isfinite(facts.vertical_fov_rad) && std::isfinite(facts.aspect);
  return view_sound ? Status(Done{}) : bad_input("the view is not finite");
}

}  // namespace poise::capture
