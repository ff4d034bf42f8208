// SPDX-License-Identifier: MIT
#include "capture/frame_packer.h"

#include <algorithm>
#include <cmath>

namespace poise::capture {
namespace {

std::int16_t pack_normal(double part) {
  return static_cast<std::int16_t>(std::lround(std::clamp(part, -1.0, 1.0) * 32767));
}

}  // namespace

// Numbers ascend with rows.
std::optional<std::uint32_t> FramePacker::row_of(std::uint64_t number) const {
  const auto found = std::ranges::lower_bound(numbers_, number);
  if (found == numbers_.end() || *found != number) return std::nullopt;
  return static_cast<std::uint32_t>(found - numbers_.begin());
}

const PackedFrame& FramePacker::pack(const SeenFrame& frame) {
  for (const CapturedBody& body : frame.new_bodies) numbers_.push_back(body.number);
  packed_.facts = frame.facts;
  packed_.rows.clear();
  packed_.poses.clear();
  packed_.activity.clear();
  packed_.level.clear();
  packed_.priority.clear();
  packed_.contacts.clear();
  auto row = numbers_.begin();
  for (const SeenBody& body : frame.bodies) {
    row = std::lower_bound(row, numbers_.end(), body.number);
    packed_.rows.push_back(static_cast<std::uint32_t>(row - numbers_.begin()));
    packed_.poses.push_back(capture::pack(body.pose, position_step_m_, orientation_steps_));
    packed_.activity.push_back(body.activity);
    packed_.level.push_back(body.level);
    packed_.priority.push_back(body.priority);
  }
  for (const SeenContact& contact : frame.contacts) {
    PackedContact& packed = packed_.contacts.emplace_back();
    packed.a = row_of(contact.a).value_or(0);
    packed.b = row_of(contact.b).value_or(0);
    packed.level = contact.level;
    packed.point_count = contact.point_count;
    for (int axis = 0; axis < 3; ++axis) {
      packed.normal[static_cast<std::size_t>(axis)] = pack_normal(contact.normal[axis]);
      for (std::size_t point = 0; point < contact.point_count; ++point) {
        packed.points[point][static_cast<std::size_t>(axis)] =
            pack_coordinate(contact.points_m[point][axis], position_step_m_);
      }
    }
  }
  return packed_;
}

const std::vector<PackedPair>& FramePacker::pack_pairs(const SeenFrame& frame) {
  packed_pairs_.clear();
  for (const SeenPair& pair : frame.pairs) {
    PackedPair& packed = packed_pairs_.emplace_back(pair.packed);
    packed.a = row_of(pair.a).value_or(0);
    packed.b = row_of(pair.b).value_or(0);
  }
  return packed_pairs_;
}

}  // namespace poise::capture
