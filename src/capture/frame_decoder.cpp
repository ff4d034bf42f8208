// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>

#include "capture/frame_code.h"
#include "capture/packed_pose.h"

namespace poise::capture {
namespace {

Error ends_early(const char* what) { return bad_input(fmt::format("it ends within {}", what)); }

// Rows that ascend, all below `end`.
Status get_list(ByteReader& bytes, const char* name, std::uint32_t end, std::vector<std::uint32_t>& rows) {
  rows.clear();
  const std::uint64_t count = bytes.varint();
  // Each row takes a byte at least.
  if (count > bytes.left())
    return bad_input(fmt::format("{} lists {} rows, more than its bytes can hold", name, count));
  std::uint64_t row = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t further = bytes.varint();
    if (!bytes.sound()) return ends_early(name);
    row += further;
    if ((i > 0 && further == 0) || row >= end)
      return bad_input(fmt::format("{}[{}] = {}, must ascend and be below {}", name, i, row, end));
    rows.push_back(static_cast<std::uint32_t>(row));
  }
  return bytes.sound() ? Status(Done{}) : ends_early(name);
}

// False: beyond what a capture may hold.
bool follow(const std::array<std::int64_t, 6>& residual, std::uint8_t largest, std::uint32_t orientation_steps,
            BodyTrack& track) {
  PackedPose pose;
  pose.largest = largest;
  const bool turned_over = largest != track.pose.largest;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t moved = track.position_step[axis] + residual[axis];
    pose.position[axis] = track.pose.position[axis] + moved;
    track.position_step[axis] = track.is_new ? 0 : moved;
    const std::int64_t turned = (turned_over ? 0 : track.orientation_step[axis]) + residual[3 + axis];
    const std::int64_t k = (turned_over ? 0 : track.pose.orientation[axis]) + turned;
    if (k < -std::int64_t{orientation_steps} || k > std::int64_t{orientation_steps}) return false;
    pose.orientation[axis] = static_cast<std::int32_t>(k);
    track.orientation_step[axis] = track.is_new || turned_over ? 0 : turned;
  }
  track.pose = pose;
  track.is_new = false;
  return sound(pose, orientation_steps);
}

}  // namespace

bool FrameDecoder::get_mask(ByteReader& bytes, std::vector<std::uint32_t>& set) const {
  set.clear();
  const std::string_view mask = bytes.take((tracks_.size() + 7) / 8);
  if (!bytes.sound()) return false;
  for (std::size_t byte = 0; byte < mask.size(); ++byte) {
    const auto bits = static_cast<unsigned char>(mask[byte]);
    if (bits == 0) continue;
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((bits >> bit & 1U) == 0) continue;
      if (8 * byte + bit >= tracks_.size()) return false;
      set.push_back(static_cast<std::uint32_t>(8 * byte + bit));
    }
  }
  return true;
}

Status FrameDecoder::change_rows(ByteReader& bytes) {
  Status read = get_list(bytes, "removed", limits_.rows, removed_);
  if (!read) return read;
  read = get_list(bytes, "added", limits_.rows, added_);
  if (!read) return read;
  next_.clear();
  std::size_t gone = 0;
  std::size_t added = 0;
  const auto add_below = [&](std::uint32_t row) {
    for (; added < added_.size() && added_[added] < row; ++added) next_.emplace_back().row = added_[added];
  };
  for (const BodyTrack& track : tracks_) {
    add_below(track.row);
    if (added < added_.size() && added_[added] == track.row)
      return bad_input(fmt::format("added has row {}, which is there already", track.row));
    if (gone < removed_.size() && removed_[gone] == track.row) {
      ++gone;
    } else {
      next_.push_back(track);
    }
  }
  add_below(limits_.rows);
  if (gone < removed_.size()) return bad_input(fmt::format("removed has row {}, which is not there", removed_[gone]));
  tracks_.swap(next_);
  return Done{};
}

Status FrameDecoder::get_poses(ByteReader& bytes) {
  if (!get_mask(bytes, set_)) return bad_input("the mask of poses is cut short or has bits beyond its bodies");
  const std::string_view largest = bytes.take(set_.size());
  if (!bytes.sound()) return ends_early("the poses");
  std::size_t listed = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const bool is_set = listed < set_.size() && set_[listed] == i;
    listed += is_set ? 1 : 0;
    if (is_set) continue;
    if (tracks_[i].is_new) return bad_input(fmt::format("row {} is new and has no pose", tracks_[i].row));
    tracks_[i].position_step = {};
    tracks_[i].orientation_step = {};
  }
  // Each number takes a byte at least.
  if (6 * set_.size() > bytes.left()) return ends_early("the poses");
  std::vector<std::array<std::int64_t, 6>> residuals(set_.size());
  for (std::size_t column = 0; column < 6; ++column) {
    for (std::array<std::int64_t, 6>& residual : residuals) residual[column] = bytes.zigzag();
  }
  if (!bytes.sound()) return ends_early("the poses");
  for (std::size_t i = 0; i < set_.size(); ++i) {
    BodyTrack& track = tracks_[set_[i]];
    const auto further = static_cast<std::uint8_t>(largest[i]);
    if (further > 3) return bad_input(fmt::format("largest of row {} = {}, must be at most 3", track.row, further));
    const auto component = static_cast<std::uint8_t>((track.pose.largest + further) & 3);
    if (!follow(residuals[i], component, limits_.orientation_steps, track))
      return bad_input(fmt::format("the pose of row {} is out of range", track.row));
  }
  return Done{};
}

Status FrameDecoder::get_bytes(ByteReader& bytes, const char* name, std::uint8_t most, std::uint8_t BodyTrack::*held) {
  if (!get_mask(bytes, set_))
    return bad_input(fmt::format("the mask of {} is cut short or has bits beyond its bodies", name));
  const std::string_view values = bytes.take(set_.size());
  if (!bytes.sound()) return ends_early(name);
  for (std::size_t i = 0; i < set_.size(); ++i) {
    const auto value = static_cast<std::uint8_t>(values[i]);
    if (value > most)
      return bad_input(fmt::format("{} of row {} = {}, must be at most {}", name, tracks_[set_[i]].row, value, most));
    tracks_[set_[i]].*held = value;
  }
  return Done{};
}

Status FrameDecoder::get_contacts(ByteReader& bytes, PackedFrame& frame) {
  constexpr std::size_t kLeastBytes = 13;
  const std::uint64_t count = bytes.varint();
  if (count > bytes.left() / kLeastBytes)
    return bad_input(fmt::format("contacts lists {} pairs, more than its bytes can hold", count));
  frame.contacts.resize(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    PackedContact& contact = frame.contacts[i];
    const std::uint64_t a = bytes.varint();
    const std::uint64_t b = bytes.varint();
    contact.level = bytes.get<Level>();
    contact.point_count = bytes.get<std::uint8_t>();
    for (std::int16_t& part : contact.normal) part = bytes.get<std::int16_t>();
    if (!bytes.sound()) return ends_early("the contacts");
    const auto there = [&](std::uint64_t row) {
      return row < limits_.rows &&
             std::binary_search(frame.rows.begin(), frame.rows.end(), static_cast<std::uint32_t>(row));
    };
    if (!there(a) || !there(b)) return bad_input(fmt::format("contacts[{}] names a row that is not there", i));
    if (contact.level > kPolygonBin || contact.point_count < 1 || contact.point_count > contact.points.size())
      return bad_input(fmt::format("contacts[{}] has level {} and {} points, must be at most {} and 1 to {}", i,
                                   contact.level, contact.point_count, kPolygonBin, contact.points.size()));
    contact.a = static_cast<std::uint32_t>(a);
    contact.b = static_cast<std::uint32_t>(b);
    const auto at = std::lower_bound(frame.rows.begin(), frame.rows.end(), contact.a) - frame.rows.begin();
    for (std::size_t point = 0; point < contact.point_count; ++point) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        contact.points[point][axis] = bytes.zigzag() + frame.poses[static_cast<std::size_t>(at)].position[axis];
    }
  }
  return bytes.sound() ? Status(Done{}) : ends_early("the contacts");
}

Status FrameDecoder::next(ByteReader& bytes, PackedFrame& frame) {
  const auto size = bytes.get<std::uint32_t>();
  ByteReader body(bytes.take(size));
  if (!bytes.sound()) return ends_early("a frame");
  Status read = get_facts(body, frame.facts);
  if (!read) return read;
  read = change_rows(body);
  if (!read) return read;
  read = get_poses(body);
  if (!read) return read;
  read = get_bytes(body, "state", kActivities - 1, &BodyTrack::activity);
  if (!read) return read;
  read = get_bytes(body, "level", kMostBodyLevel, &BodyTrack::level);
  if (!read) return read;
  read = get_bytes(body, "priority", 255, &BodyTrack::priority);
  if (!read) return read;
  frame.rows.clear();
  frame.poses.clear();
  frame.activity.clear();
  frame.level.clear();
  frame.priority.clear();
  for (const BodyTrack& track : tracks_) {
    frame.rows.push_back(track.row);
    frame.poses.push_back(track.pose);
    frame.activity.push_back(track.activity);
    frame.level.push_back(track.level);
    frame.priority.push_back(track.priority);
  }
  frame.contacts.clear();
  if (limits_.contacts) read = get_contacts(body, frame);
  if (!read) return read;
  return body.left() == 0 ? Status(Done{}) : bad_input(fmt::format("{} bytes stand behind a frame", body.left()));
}

}  // namespace poise::capture
