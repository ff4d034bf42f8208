// SPDX-License-Identifier: MIT
#include "app/live/live_feed.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/captures.h"
#include "capture/frame_code.h"

namespace poise::app {
namespace {

using testing::some_frames;
using testing::some_header;

/// Reads what a browser is sent, as a page does.
class Reader {
 public:
  Reader(LiveFeed& feed, ClientId client) : feed_(feed), client_(client) { feed_.join(client); }

  /// Everything that is there to be sent, and with `shows` tells that it is shown.
  void read(bool shows = true) {
    while (const WebMessage message = feed_.next(client_)) take(*message);
    if (shows && has_frame_) feed_.shown(client_, number_);
  }
  std::size_t heads = 0, shapes = 0, frames = 0, keys = 0, tables = 0;
  std::vector<nlohmann::json> told;
  std::size_t rows = 0;
  std::uint32_t first_row_number = 0;
  capture::PackedFrame frame;

 private:
  void take(const WebBytes& message) {
    if (message.is_text) {
      told.push_back(nlohmann::json::parse(message.bytes));
      return;
    }
    const std::string_view bytes = message.bytes;
    const std::string_view type = bytes.substr(0, 4), payload = bytes.substr(4);
    heads += type == "HEAD" ? 1U : 0U;
    shapes += type == "SHAP" ? 1U : 0U;
    if (type == "BODY") {
      const auto table = nlohmann::json::parse(payload);
      if (table.at("first") == 0) {
        ++tables;
        rows = 0;
        first_row_number = table.at("number").at(0).get<std::uint32_t>();
      }
      EXPECT_EQ(table.at("first"), rows);
      rows += table.at("number").size();
    }
    if (type != "FRAM") return;
    ++frames;
    capture::ByteReader reader(payload);
    const bool is_key = reader.get<std::uint32_t>() == 1;
    number_ = reader.get<std::uint32_t>();
    has_frame_ = true;
    keys += is_key ? 1U : 0U;
    // The table grows while frames follow each other.
    constexpr std::uint32_t kAnyRow = 1'000'000;
    if (is_key) decoder_.emplace(capture::FrameDecoder::Limits{kAnyRow, 4096, false});
    const Status read = decoder_->next(reader, frame);
    EXPECT_TRUE(read.ok()) << (read ? "" : read.error().message);
    EXPECT_EQ(reader.left(), 0U);
    for (const std::uint32_t row : frame.rows) EXPECT_LT(row, rows);
  }

  LiveFeed& feed_;
  ClientId client_;
  std::optional<capture::FrameDecoder> decoder_;
  std::uint32_t number_ = 0;
  bool has_frame_ = false;
};

LiveRecord record_of(capture::SeenFrame frame, std::uint64_t run = 1) {
  LiveRecord record;
  record.run = run;
  record.has_frame = true;
  record.frame = std::move(frame);
  return record;
}

void give(LiveFeed& feed, const capture::SeenFrame& frame, std::uint64_t run = 1) {
  LiveRecord record = record_of(frame, run);
  feed.take(record);
}

/// The frame by itself, as a capture would hold it.
void expect_shows(const Reader& reader, const capture::SeenFrame& frame, const capture::CaptureHeader& header) {
  ASSERT_EQ(reader.frame.rows.size(), frame.bodies.size());
  for (std::size_t i = 0; i < frame.bodies.size(); ++i) {
    EXPECT_EQ(reader.frame.poses[i],
              capture::pack(frame.bodies[i].pose, header.position_step_m, header.orientation_steps));
    EXPECT_EQ(reader.frame.level[i], frame.bodies[i].level);
  }
  EXPECT_EQ(reader.frame.facts.frame, frame.facts.frame);
}

TEST(LiveFeed, ABrowserGetsHeadAndTableAndThenAllFrames) {
  const capture::CaptureHeader header = some_header();
  LiveFeed feed(header);
  Reader reader(feed, 1);
  for (const capture::SeenFrame& frame : some_frames(1, 50, 20)) {
    give(feed, frame);
    reader.read();
    expect_shows(reader, frame, header);
  }
  EXPECT_EQ(reader.heads, 1U);
  EXPECT_EQ(reader.shapes, header.shapes.size());
  EXPECT_EQ(reader.frames, 50U);
  EXPECT_EQ(reader.keys, 1U);
}

TEST(LiveFeed, ABrowserThatComesLaterGetsAKeyAndTheOthersMissNothing) {
  const capture::CaptureHeader header = some_header();
  LiveFeed feed(header);
  Reader first(feed, 1);
  std::optional<Reader> second;
  const std::vector<capture::SeenFrame> frames = some_frames(2, 60, 20);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i == 20) second.emplace(feed, 2);
    give(feed, frames[i]);
    first.read();
    expect_shows(first, frames[i], header);
    if (!second) continue;
    second->read();
    if (second->frames > 0) expect_shows(*second, frames[i], header);
  }
  EXPECT_EQ(first.frames, 60U);
  EXPECT_EQ(second->frames, 40U);
  EXPECT_EQ(first.keys, 2U);
  EXPECT_EQ(feed.dropped(2), 0U);
}

TEST(LiveFeed, ABrowserThatNeverShowsMissesFramesAndTheOthersNone) {
  const capture::CaptureHeader header = some_header();
  LiveFeed feed(header);
  Reader slow(feed, 1), quick(feed, 2);
  const std::vector<capture::SeenFrame> frames = some_frames(3, 200, 20);
  for (const capture::SeenFrame& frame : frames) {
    give(feed, frame);
    slow.read(false);
    quick.read();
    expect_shows(quick, frame, header);
  }
  EXPECT_EQ(slow.frames, ClientQueue::kMostAhead);
  EXPECT_EQ(feed.dropped(1), 200 - ClientQueue::kMostAhead);
  EXPECT_EQ(quick.frames, 200U);
  EXPECT_EQ(quick.keys, 1U) << "it cost nobody a key";
  // It wakes up.
  slow.read();
  capture::SeenFrame next = frames.back();
  next.new_bodies.clear();
  for (int i = 0; i < 2; ++i) {
    give(feed, next);
    slow.read();
  }
  expect_shows(slow, next, header);
}

TEST(LiveFeed, WhoComesWhileItIsPausedSeesTheLastFrame) {
  const capture::CaptureHeader header = some_header();
  LiveFeed feed(header);
  const std::vector<capture::SeenFrame> frames = some_frames(4, 10, 20);
  for (const capture::SeenFrame& frame : frames) give(feed, frame);
  Reader reader(feed, 1);
  LiveRecord tick;
  tick.run = 1;
  feed.take(tick);
  reader.read();
  ASSERT_EQ(reader.frames, 1U);
  expect_shows(reader, frames.back(), header);
  feed.take(tick);
  reader.read();
  EXPECT_EQ(reader.frames, 1U) << "and nothing again";
}

TEST(LiveFeed, ANewStartHasBodiesOfItsOwn) {
  const capture::CaptureHeader header = some_header();
  LiveFeed feed(header);
  Reader reader(feed, 1);
  for (const std::uint64_t run : {1U, 2U}) {
    for (const capture::SeenFrame& frame : some_frames(4 + run, 10, 20)) {
      give(feed, frame, run);
      reader.read();
      expect_shows(reader, frame, header);
    }
  }
  EXPECT_EQ(reader.keys, 2U);
  EXPECT_EQ(reader.tables, 2U);
}

TEST(LiveFeed, BodiesThatHaveLeftDoNotFillTheTable) {
  const capture::CaptureHeader header = some_header();
  LiveFeed feed(header);
  Reader reader(feed, 1);
  // Each frame has another body.
  for (std::uint64_t number = 0; number < 3000; ++number) {
    capture::SeenFrame frame;
    frame.facts.frame = number;
    frame.new_bodies.resize(1);
    frame.new_bodies[0].number = number;
    frame.bodies.resize(1);
    frame.bodies[0].number = number;
    give(feed, frame);
    reader.read();
    ASSERT_EQ(reader.frame.rows.size(), 1U);
    EXPECT_LE(reader.rows, 1020U);
  }
  EXPECT_EQ(reader.tables, 3U);
  EXPECT_GT(reader.first_row_number, 0U);
}

TEST(LiveFeed, WhoComesAfterNobodyLookedSeesAllBodies) {
  const capture::CaptureHeader header = some_header();
  LiveFeed feed(header);
  std::optional<Reader> reader;
  const std::vector<capture::SeenFrame> frames = some_frames(6, 90, 20);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i == 30 || i == 70) reader.emplace(feed, i);
    if (i == 50) feed.leave(30);
    give(feed, frames[i]);
    if (i < 30 || (i >= 50 && i < 70)) continue;
    reader->read();
    expect_shows(*reader, frames[i], header);
  }
}

TEST(LiveFeed, AStartThatIsToldOfBeforeItsFirstFrameIsNew) {
  const capture::CaptureHeader header = some_header();
  LiveFeed feed(header);
  Reader reader(feed, 1);
  give(feed, some_frames(1, 1, 20).front());
  LiveRecord tick;
  tick.run = 2;
  feed.take(tick);
  const capture::SeenFrame frame = some_frames(2, 1, 10).front();
  give(feed, frame, 2);
  reader.read();
  expect_shows(reader, frame, header);
}

TEST(LiveFeed, TellsTheStatusAndErrors) {
  LiveFeed feed(some_header());
  Reader reader(feed, 7);
  LiveRecord record = record_of(some_frames(1, 1, 5).front());
  record.status.deadline_ms = 8;
  record.status.bodies = 3;
  record.status.recent = {10, 2, 0, 0, 1, 0};
  record.replies.push_back({7, "message: ms = 0, must be > 0"});
  record.replies.push_back({8, "to another"});
  feed.take(record);
  reader.read();
  ASSERT_GE(reader.told.size(), 2U);
  EXPECT_EQ(reader.told[0].at("error"), "message: ms = 0, must be > 0");
  const nlohmann::json status = reader.told[1].at("status");
  EXPECT_EQ(status.at("deadline_ms"), 8);
  EXPECT_EQ(status.at("bodies"), 3);
  EXPECT_EQ(status.at("recent_frames"), 13);
  EXPECT_EQ(status.at("late").at("infeasible"), 2);
  EXPECT_EQ(status.at("late").at("forecast"), 1);
  EXPECT_EQ(status.at("browsers"), 1);
  EXPECT_EQ(status.at("policy"), "perceptual");
  EXPECT_EQ(status.at("weights").at("closing").at("value"), 1);
}

}  // namespace
}  // namespace poise::app
