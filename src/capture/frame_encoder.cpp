// SPDX-License-Identifier: MIT
#include <algorithm>

#include "capture/frame_code.h"

namespace poise::capture {
namespace {

void put_list(const std::vector<std::uint32_t>& rows, std::string& out) {
  put_varint(rows.size(), out);
  std::uint32_t before = 0;
  for (const std::uint32_t row : rows) {
    put_varint(row - before, out);
    before = row;
  }
}

void set_bit(std::size_t i, std::string& mask) {
  mask[i / 8] = static_cast<char>(static_cast<unsigned char>(mask[i / 8]) | (1U << (i % 8)));
}

// What is to be told of a pose that is not the one before: the differences to what the track leads to. Updates the
// track.
std::array<std::int64_t, 6> follow(const PackedPose& pose, BodyTrack& track) {
  std::array<std::int64_t, 6> residual{};
  const bool turned_over = pose.largest != track.pose.largest;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t moved = pose.position[axis] - track.pose.position[axis];
    residual[axis] = moved - track.position_step[axis];
    track.position_step[axis] = track.is_new ? 0 : moved;
    const std::int64_t turned = pose.orientation[axis] - (turned_over ? 0 : track.pose.orientation[axis]);
    residual[3 + axis] = turned - (turned_over ? 0 : track.orientation_step[axis]);
    track.orientation_step[axis] = track.is_new || turned_over ? 0 : turned;
  }
  track.pose = pose;
  track.is_new = false;
  return residual;
}

}  // namespace

void FrameEncoder::change_rows(const PackedFrame& frame) {
  list_.clear();
  next_.clear();
  std::size_t before = 0;
  for (const std::uint32_t row : frame.rows) {
    for (; before < tracks_.size() && tracks_[before].row < row; ++before) list_.push_back(tracks_[before].row);
    if (before < tracks_.size() && tracks_[before].row == row) {
      next_.push_back(tracks_[before++]);
    } else {
      next_.emplace_back().row = row;
    }
  }
  for (; before < tracks_.size(); ++before) list_.push_back(tracks_[before].row);
  put_list(list_, body_);
  list_.clear();
  for (const BodyTrack& track : next_) {
    if (track.is_new) list_.push_back(track.row);
  }
  put_list(list_, body_);
  tracks_.swap(next_);
}

void FrameEncoder::put_poses(const PackedFrame& frame) {
  mask_.assign((tracks_.size() + 7) / 8, '\0');
  residuals_.clear();
  std::string largest;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    BodyTrack& track = tracks_[i];
    if (!track.is_new && frame.poses[i] == track.pose) {
      track.position_step = {};
      track.orientation_step = {};
      continue;
    }
    set_bit(i, mask_);
    largest.push_back(static_cast<char>((frame.poses[i].largest - track.pose.largest) & 3));
    residuals_.push_back(follow(frame.poses[i], track));
  }
  body_ += mask_;
  body_ += largest;
  for (std::size_t column = 0; column < 6; ++column) {
    for (const std::array<std::int64_t, 6>& residual : residuals_) put_zigzag(residual[column], body_);
  }
}

void FrameEncoder::put_bytes(const std::vector<std::uint8_t>& column, std::uint8_t BodyTrack::*held) {
  mask_.assign((tracks_.size() + 7) / 8, '\0');
  std::string values;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (tracks_[i].*held == column[i]) continue;
    set_bit(i, mask_);
    tracks_[i].*held = column[i];
    values.push_back(static_cast<char>(column[i]));
  }
  body_ += mask_;
  body_ += values;
}

void FrameEncoder::add(const PackedFrame& frame, std::string& out) {
  body_.clear();
  put_facts(frame.facts, body_);
  change_rows(frame);
  put_poses(frame);
  put_bytes(frame.activity, &BodyTrack::activity);
  put_bytes(frame.level, &BodyTrack::level);
  put_bytes(frame.priority, &BodyTrack::priority);
  if (contacts_) {
    put_varint(frame.contacts.size(), body_);
    std::size_t at = 0;
    for (const PackedContact& contact : frame.contacts) {
      put_varint(contact.a, body_);
      put_varint(contact.b, body_);
      put(contact.level, body_);
      put(contact.point_count, body_);
      for (const std::int16_t part : contact.normal) put(part, body_);
      // Contacts come in the order of their first body.
      if (at >= frame.rows.size() || frame.rows[at] != contact.a) {
        at = static_cast<std::size_t>(std::lower_bound(frame.rows.begin(), frame.rows.end(), contact.a) -
                                      frame.rows.begin());
      }
      for (std::size_t point = 0; point < contact.point_count; ++point) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          put_zigzag(contact.points[point][axis] - frame.poses[at].position[axis], body_);
      }
    }
  }
  put(static_cast<std::uint32_t>(body_.size()), out);
  out += body_;
}

}  // namespace poise::capture
