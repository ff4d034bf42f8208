// SPDX-License-Identifier: MIT
#include "scene/policy_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "scene/temporary_folder.h"

namespace poise::io {
namespace {

using testing::TemporaryFolder;

std::string file_of(const TemporaryFolder& folder, const std::string& text) {
  const std::string path = folder.file("mine.json");
  std::ofstream(path) << text;
  return path;
}

TEST(PolicyFile, HasANameAndWhatAScenesPolicyMayHave) {
  const TemporaryFolder folder;
  const std::string path = file_of(folder, R"({
    "schema": "poise.policy/1", "name": "near first", "evidence": {"anything": [1, 2]},
    "policy": {"kind": "size", "closing": 0, "round_pairs": 64}})");
  scheduler::Policy base;
  base.waiting = 3;
  const Result<PolicyFile> file = read_policy_file(path, base);
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_EQ(file.value().name, "near first");
  EXPECT_EQ(file.value().policy.kind, scheduler::PolicyKind::Size);
  EXPECT_EQ(file.value().policy.closing, 0);
  EXPECT_EQ(file.value().policy.round_pairs, 64U);
  EXPECT_EQ(file.value().policy.waiting, 3) << "what the file does not say stays";
}

TEST(PolicyFile, IsRefusedWithFileFieldValueAndRule) {
  const TemporaryFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"", "mine.json: the file is empty"},
      {"{", "mine.json: line 1, column 2"},
      {"[]", "mine.json"},
      {R"({"name": "a", "policy": {}})", "schema"},
      {R"({"schema": "poise.policy/2", "name": "a", "policy": {}})",
       "mine.json: schema = \"poise.policy/2\", must be \"poise.policy/1\""},
      {R"({"schema": "poise.policy/1", "policy": {}})", "name"},
      {R"({"schema": "poise.policy/1", "name": "", "policy": {}})", "mine.json: name = \"\", must not be empty"},
      {R"({"schema": "poise.policy/1", "name": "a"})", "policy"},
      {R"({"schema": "poise.policy/1", "name": "a", "policy": {"closing": 11}})",
       "mine.json: policy.closing = 11, must be"},
      {R"({"schema": "poise.policy/1", "name": "a", "policy": {"kind": "best"}})", "policy.kind"},
      {R"({"schema": "poise.policy/1", "name": "a", "policy": {}, "evidence": 3})",
       "mine.json: evidence = 3, must be an object"},
      {R"({"schema": "poise.policy/1", "name": "a", "policy": {}, "weights": {}})", "weights"}};
  for (const auto& [text, message] : cases) {
    std::vector<std::string> errors;
    const Result<PolicyFile> file = read_policy_file(file_of(folder, text), {}, &errors);
    ASSERT_FALSE(file.ok()) << text;
    EXPECT_NE(file.error().message.find(message), std::string::npos) << file.error().message;
    ASSERT_FALSE(errors.empty());
    EXPECT_EQ(errors.front(), file.error().message);
  }
  EXPECT_NE(read_policy_file(folder.file("none.json"), {}).error().message.find("no such file"), std::string::npos);
}

TEST(PolicyFile, IsMeantByAFolderOrAnEnding) {
  EXPECT_TRUE(names_policy_file("a/b"));
  EXPECT_TRUE(names_policy_file("mine.json"));
  EXPECT_FALSE(names_policy_file("fifo"));
}

TEST(SetWeight, SetsACueAndRefusesWhatIsNone) {
  scheduler::Policy policy;
  EXPECT_TRUE(set_weight("closing=2.5", policy).ok());
  EXPECT_EQ(policy.closing, 2.5);
  const auto refused = [&](const char* text) { return set_weight(text, policy).error().message; };
  EXPECT_EQ(refused("closing=11"), "closing = 11, must be from 0 to 10");
  EXPECT_EQ(refused("closing=nan"), "closing = nan, must be from 0 to 10");
  EXPECT_EQ(refused("closing="), "closing = , must be from 0 to 10");
  EXPECT_EQ(refused("closing"),
            "\"closing\", must be CUE=VALUE with a CUE of frustum, size, eccentricity, closing, waiting, importance, "
            "host, occlusion, gap, delay, onset, crowding, attention, hysteresis or touch");
  EXPECT_TRUE(refused("speed=1").starts_with("\"speed=1\", must be CUE=VALUE")) << refused("speed=1");
  EXPECT_EQ(policy.closing, 2.5) << "nothing changes";
}

}  // namespace
}  // namespace poise::io
