// SPDX-License-Identifier: MIT
#include "app/live/client_queue.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace poise::app {
namespace {

WebMessage message(const std::string& bytes) { return std::make_shared<WebBytes>(WebBytes{true, bytes}); }

std::string next(ClientQueue& queue) {
  const WebMessage got = queue.next();
  return got ? got->bytes : "";
}

TEST(ClientQueue, BeginsWithTheHeadAndAKey) {
  ClientQueue queue({message("head"), message("shape")});
  EXPECT_TRUE(queue.takes_key());
  queue.frame(0, {message("0")}, false);
  EXPECT_EQ(queue.dropped(), 0U) << "before its first frame a browser misses nothing";
  queue.frame(1, {message("table"), message("1")}, true);
  queue.frame(2, {message("2")}, false);
  for (const char* const wanted : {"head", "shape", "table", "1", "2", ""}) EXPECT_EQ(next(queue), wanted);
}

TEST(ClientQueue, AnswersComeBetweenFramesAndTheLastStatusAlone) {
  ClientQueue queue({});
  queue.frame(0, {message("table"), message("0")}, true);
  EXPECT_EQ(next(queue), "table");
  queue.status(message("old"));
  queue.status(message("new"));
  queue.reply(message("error"));
  for (const char* const wanted : {"0", "error", "new", ""}) EXPECT_EQ(next(queue), wanted);
}

TEST(ClientQueue, KeepsABoundedNumberOfAnswers) {
  ClientQueue queue({});
  for (std::size_t i = 0; i < ClientQueue::kMostReplies + 5; ++i) queue.reply(message(std::to_string(i)));
  EXPECT_EQ(next(queue), "5");
  std::size_t left = 0;
  while (queue.next()) ++left;
  EXPECT_EQ(left, ClientQueue::kMostReplies - 1);
}

TEST(ClientQueue, AReaderThatStandsStillMissesFramesUntilItHasShownWhatItHas) {
  ClientQueue queue({});
  queue.frame(0, {message("key")}, true);
  std::uint32_t number = 1;
  for (; number < 100; ++number) {
    queue.frame(number, {message("frame")}, false);
    next(queue);
    next(queue);
  }
  EXPECT_TRUE(queue.waits_for_key());
  EXPECT_FALSE(queue.takes_key());
  EXPECT_EQ(queue.dropped(), 100 - ClientQueue::kMostAhead);
  queue.frame(number, {message("key")}, true);
  EXPECT_EQ(queue.dropped(), 101 - ClientQueue::kMostAhead) << "it costs nobody a key";
  queue.shown(ClientQueue::kMostAhead);
  EXPECT_TRUE(queue.takes_key());
  queue.frame(++number, {message("again")}, true);
  EXPECT_EQ(next(queue), "again");
  EXPECT_FALSE(queue.waits_for_key());
}

TEST(ClientQueue, FramesThatWereNotSentAreOfNoUseBeforeAKey) {
  ClientQueue queue({});
  queue.frame(0, {message("table"), message("key")}, true);
  EXPECT_EQ(next(queue), "table");
  for (std::uint32_t number = 1; number <= ClientQueue::kMostAhead; ++number)
    queue.frame(number, {message("f")}, false);
  EXPECT_EQ(queue.dropped(), ClientQueue::kMostAhead);
  EXPECT_EQ(next(queue), "key") << "what was begun is sent to its end";
  EXPECT_EQ(next(queue), "");
  EXPECT_TRUE(queue.takes_key());
}

TEST(ClientQueue, WhatWasNotSentCannotHaveBeenShown) {
  ClientQueue queue({});
  queue.frame(0, {message("key")}, true);
  for (std::uint32_t number = 1; number < ClientQueue::kMostAhead; ++number) queue.frame(number, {message("f")}, false);
  queue.shown(1'000'000);
  queue.frame(50, {message("f")}, false);
  EXPECT_TRUE(queue.waits_for_key());
}

}  // namespace
}  // namespace poise::app
