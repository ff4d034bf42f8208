// SPDX-License-Identifier: MIT
#include "sweep/trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "scene/temporary_folder.h"
#include "sweep/specs.h"
#include "sweep/trial_batch.h"

namespace poise::testing {
namespace {

using sweep::Trial;

std::vector<Trial> expanded(const nlohmann::ordered_json& spec, const std::string& build = "build") {
  const Result<std::vector<Trial>> trials = sweep::expand(spec_of(spec), small_scenes(), build);
  EXPECT_TRUE(trials) << trials.error().message;
  return trials.value_or({});
}

TEST(Expansion, HasEveryCombinationOnceTheLastAxisAndRepeatsFastest) {
  const std::vector<Trial> trials = expanded(small_spec());
  ASSERT_EQ(trials.size(), 16U);
  EXPECT_EQ(trials[0].label, "a, bodies=10, budget_work=100, repeat 1");
  EXPECT_EQ(trials[1].label, "a, bodies=10, budget_work=100, repeat 2");
  EXPECT_EQ(trials[2].label, "a, bodies=10, budget_work=200, repeat 1");
  EXPECT_EQ(trials[4].label, "a, bodies=20, budget_work=100, repeat 1");
  EXPECT_EQ(trials[8].label, "b, bodies=10, budget_work=100, repeat 1");
  std::set<std::string> keys;
  for (const Trial& trial : trials) keys.insert(trial.key);
  EXPECT_EQ(keys.size(), 16U);
}

TEST(Expansion, WithoutAxesIsOneTrialForEachScene) {
  nlohmann::ordered_json spec = small_spec();
  spec.erase("axes");
  spec.erase("repeats");
  ASSERT_EQ(expanded(spec).size(), 2U);
  EXPECT_EQ(expanded(spec)[1].label, "b");
}

TEST(Expansion, RefusesScenesWithTheSameContent) {
  std::vector<sweep::SceneFile> scenes = small_scenes();
  scenes[1].hash = scenes[0].hash;
  const auto trials = sweep::expand(spec_of(small_spec()), scenes, "build");
  ASSERT_FALSE(trials);
  EXPECT_NE(trials.error().message.find("two trials would be the same run: b, bodies=10"), std::string::npos)
      << trials.error().message;
}

TEST(Expansion, ATrialByTheWallClockNeedsTheCoresOfItsThreads) {
  nlohmann::ordered_json spec = small_spec();
  spec["settings"] = {{"frames", 10}};
  spec["axes"] = {{"threads", {0, 1, 3}}};
  spec["repeats"] = 1;
  const std::vector<Trial> trials = expanded(spec);
  EXPECT_EQ(trials[0].cores, 1U);
  EXPECT_EQ(trials[2].cores, 3U);
  EXPECT_TRUE(trials[0].timed);
  EXPECT_FALSE(expanded(small_spec())[0].timed);
  spec["trial"] = {{"cores", 2}};
  EXPECT_EQ(expanded(spec)[2].cores, 2U) << "what the specification says";
}

TEST(TrialKey, DependsOnAllThatTheResultDependsOnAndOnNothingElse) {
  const Trial base = expanded(small_spec())[0];
  const auto key = [](const Trial& trial, const std::string& build = "build") {
    return sweep::trial_key(trial, build).value_or("refused");
  };
  const auto changed = [&](const std::function<void(Trial&)>& change) {
    Trial trial = base;
    change(trial);
    return key(trial);
  };
  EXPECT_EQ(base.key.size(), 32U);
  EXPECT_EQ(key(base), base.key);
  EXPECT_NE(key(base, "another build"), base.key);
  EXPECT_NE(changed([](Trial& t) { t.scene_hash += "x"; }), base.key);
  EXPECT_NE(changed([](Trial& t) { t.settings[0].text = "11"; }), base.key);
  EXPECT_NE(changed([](Trial& t) { t.settings[0].name = "warmup"; }), base.key);
  EXPECT_NE(changed([](Trial& t) { t.settings.pop_back(); }), base.key);
  EXPECT_NE(changed([](Trial& t) { t.repeat = 2; }), base.key);
  EXPECT_EQ(changed([](Trial& t) { std::ranges::reverse(t.settings); }), base.key) << "their order does not matter";
  EXPECT_EQ(changed([](Trial& t) { t.time_limit_s = 1; }), base.key) << "what is done is done";
  EXPECT_EQ(changed([](Trial& t) { t.scene_file = "/elsewhere.json"; }), base.key);
  EXPECT_EQ(changed([](Trial& t) { t.cores = 7; }), base.key) << "counted work is the same on any number";
  EXPECT_NE(changed([](Trial& t) { t.timed = true, t.cores = 7; }), changed([](Trial& t) { t.timed = true; }));
}

TEST(TrialKey, DependsOnTheContentOfPolicyFilesAndNotOnTheirNames) {
  const TemporaryFolder folder;
  Trial trial = expanded(small_spec())[0];
  trial.base = folder.path();
  const auto key_with = [&](const char* name, const char* text) {
    std::ofstream(folder.file(name)) << text;
    trial.settings.back() = {"policy", name, {}};
    return sweep::trial_key(trial, "build").value_or("refused");
  };
  const std::string first = key_with("p.json", "one");
  EXPECT_EQ(key_with("q.json", "one"), first);
  EXPECT_NE(key_with("p.json", "two"), first);
  trial.settings.back().text = "none.json";
  const Result<std::string> none = sweep::trial_key(trial, "build");
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("none.json"), std::string::npos);
}

TEST(SceneHash, DependsOnTextAndMeshes) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("ball.obj")) << "one";
  Scene scene;
  scene.source = "scene.json";
  scene.base = folder.path();
  MeshSource ball;
  ball.file = "ball.obj";
  scene.shapes.push_back({"ball", ball});
  const std::string first = sweep::scene_hash("text", scene).value_or("refused");
  EXPECT_NE(sweep::scene_hash("other", scene).value_or(""), first);
  std::ofstream(folder.file("ball.obj")) << "two";
  EXPECT_NE(sweep::scene_hash("text", scene).value_or(""), first);
  std::ofstream(folder.file("ball.obj")) << "one";
  EXPECT_EQ(sweep::scene_hash("text", scene).value_or(""), first);
  TreeSource tree;
  tree.file = "none.sph";
  scene.shapes.push_back({"tree", tree});
  const Result<std::string> missing = sweep::scene_hash("text", scene);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("scene.json: "), std::string::npos);
}

TEST(TrialWords, AreThoseOfPoiseRun) {
  nlohmann::ordered_json spec = small_spec();
  spec["settings"] = nlohmann::ordered_json::parse(R"({"paced": true, "sleeping": false, "deadline_ms": 4,
      "weight.closing": 2.5, "reference_every": 60, "max_level": "polygons", "policy": "mine/p.json", "gaze": "g.csv"})");
  spec.erase("axes");
  sweep::SweepSpec read = spec_of(spec);
  read.base = "/folder";
  read.settings.erase(read.settings.end() - 2, read.settings.end());
  Result<std::vector<Trial>> trials = sweep::expand(read, small_scenes(), "build");
  ASSERT_TRUE(trials);
  Trial trial = trials.value()[0];
  trial.settings.push_back({"policy", "mine/p.json", {}});
  trial.settings.push_back({"gaze", "g.csv", {}});
  const std::vector<std::string> words = {"run",
                                          "/a.json",
                                          "--paced",
                                          "--no-sleeping",
                                          "--deadline",
                                          "4",
                                          "--weight",
                                          "closing=2.5",
                                          "--reference",
                                          "every=60",
                                          "--max-level",
                                          "polygons",
                                          "--policy",
                                          "/folder/mine/p.json",
                                          "--gaze",
                                          "/folder/g.csv",
                                          "--no-time-priors",
                                          "--quiet",
                                          "--json",
                                          "out.json"};
  EXPECT_EQ(sweep::trial_words(trial, "out.json"), words);
}

TEST(TrialBatch, IsReadAsItWasWrittenAndGivesEachTaskItsTrials) {
  const TemporaryFolder folder;
  sweep::TrialBatch batch;
  batch.trials = expanded(small_spec());
  batch.trials.resize(5);
  batch.per_task = 2;
  batch.exclusive = true;
  std::ofstream(folder.file("b.json")) << sweep::batch_json(batch);
  const Result<sweep::TrialBatch> read = sweep::read_batch(folder.file("b.json"));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().tasks(), 3U);
  EXPECT_TRUE(read.value().exclusive);
  EXPECT_EQ(read.value().of_task(0).size(), 2U);
  ASSERT_EQ(read.value().of_task(2).size(), 1U);
  EXPECT_TRUE(read.value().of_task(3).empty());
  EXPECT_TRUE(read.value().of_task(~std::uint64_t{0}).empty());
  const Trial last = read.value().of_task(2)[0];
  EXPECT_EQ(last.key, batch.trials[4].key);
  EXPECT_EQ(sweep::trial_words(last, "j"), sweep::trial_words(batch.trials[4], "j"));
  EXPECT_EQ(sweep::trial_key(last, "build").value_or(""), last.key) << "all that the key depends on came along";
}

TEST(TrialBatch, RefusesWhatItDoesNotKnow) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& text) {
    std::ofstream(folder.file("b.json")) << text;
    const Result<sweep::TrialBatch> read = sweep::read_batch(folder.file("b.json"));
    return read ? std::string("accepted") : read.error().message;
  };
  EXPECT_NE(refusal("{}").find("schema: missing"), std::string::npos);
  EXPECT_NE(refusal(R"({"schema": "poise.sweep/1"})").find("must be \"poise.sweep-batch/1\""), std::string::npos);
  sweep::TrialBatch batch;
  batch.trials = {expanded(small_spec())[0]};
  batch.trials[0].key = "../../elsewhere";
  EXPECT_NE(refusal(sweep::batch_json(batch)).find("trials[0].key: must be 32 hexadecimal digits"), std::string::npos);
}

// 2^64 - 1 trials a task overflowed the number of tasks, and a task then had trials up to before its first.
TEST(TrialBatch, RefusesMoreTrialsATaskThanASweepMayHave) {
  sweep::TrialBatch batch;
  batch.trials = {expanded(small_spec())[0]};
  batch.per_task = sweep::kMostTrials;
  EXPECT_TRUE(sweep::parse_batch(sweep::batch_json(batch), "b.json"));
  batch.per_task = ~std::uint64_t{0};
  const Result<sweep::TrialBatch> read = sweep::parse_batch(sweep::batch_json(batch), "b.json");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("per_task = 18446744073709551615, must be a whole number from 1 to 100000"),
            std::string::npos)
      << read.error().message;
}

TEST(TrialBatch, HasAtMostAsManyTasksAsThereMayBe) {
  EXPECT_EQ(sweep::trials_per_task(40, 1001), 1U);
  EXPECT_EQ(sweep::trials_per_task(40, 40), 1U);
  EXPECT_EQ(sweep::trials_per_task(40, 39), 2U);
  EXPECT_EQ(sweep::trials_per_task(40, 12), 4U);
  EXPECT_EQ(sweep::trials_per_task(40, 0), 40U);
  EXPECT_EQ(sweep::trials_per_task(0, 12), 1U);
}

}  // namespace
}  // namespace poise::testing
