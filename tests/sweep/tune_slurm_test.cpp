// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sweep/slurm_site.h"
#include "sweep/sweep_runs.h"
#include "sweep/tune_study.h"

namespace poise::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class SlurmTune : public SlurmSite {
 protected:
  void SetUp() override {
    const std::string why = why_no_search();
    if (!why.empty()) GTEST_SKIP() << why;
    SlurmSite::SetUp();
  }
  static std::vector<std::string> two_workers(const std::string& trials) {
    return {"--trials", trials, "--engine", "slurm", "--workers", "2"};
  }
  static std::string array_of(const StudyFolder& study, const std::string& number = "001") {
    return study.workers() + "/slurm/" + number;
  }
};

/// Waits until both workers have a trial that is held up.
bool both_work(const StudyFolder& study) {
  return wait_for([&] { return study.journal().working.size() == 2; });
}

TEST_F(SlurmTune, GivesTheValuesOfTheLocalEngine) {
  const StudyFolder slurm, local;
  Program array(slurm.file(""), slurm.words(two_workers("8")));
  ASSERT_EQ(array.wait(), 0) << array.error();
  EXPECT_TRUE(says(array.error(), "job array " + job_of(array_of(slurm)) + " of 2 workers")) << array.error();
  Program process(local.file(""), local.words({"--trials", "8"}));
  ASSERT_EQ(process.wait(), 0) << process.error();
  const StudyFolder::Journal far = slurm.journal(), near = local.journal();
  EXPECT_EQ(far.done, 8U);
  EXPECT_EQ(far.failed, 0U);
  std::size_t both = 0;
  for (const auto& [policy, value] : far.values) {
    const auto same = near.values.find(policy);
    if (same == near.values.end()) continue;
    ++both;
    EXPECT_EQ(value, same->second) << policy;
  }
  EXPECT_GE(both, 5U) << "what is tried first is the same";
  const json file = json::parse(contents(slurm.out()));
  EXPECT_EQ(file.at("evidence").at("trials"), json({{"done", 8}, {"failed", 0}}));
}

TEST_F(SlurmTune, AKilledTaskLosesItsTrialToTheOther) {
  const StudyFolder study;
  study.hold_up();
  Program program(study.file(""), study.slow_words(two_workers("6")));
  ASSERT_TRUE(both_work(study)) << program.error() << contents(array_of(study) + "/task-0.log");
  ask("scancel --signal=KILL " + job_of(array_of(study)) + "_0");
  ASSERT_TRUE(wait_for([&] { return study.journal().retried == 1; })) << program.error();
  study.go_on();
  EXPECT_EQ(program.wait(), 0) << program.error();
  const StudyFolder::Journal journal = study.journal();
  EXPECT_EQ(journal.done, 6U);
  EXPECT_EQ(journal.values.size(), 6U) << "the lost policy is one of the six";
  EXPECT_EQ(journal.worked.size(), 1U);
  EXPECT_FALSE(fs::exists(array_of(study, "002"))) << "nothing was submitted again";
}

TEST_F(SlurmTune, ACancelledArrayIsGoneOnWithByTheSameCommand) {
  const StudyFolder study;
  study.hold_up();
  {
    Program program(study.file(""), study.slow_words(two_workers("6")));
    ASSERT_TRUE(both_work(study)) << program.error();
    ask("scancel " + job_of(array_of(study)));
    EXPECT_EQ(program.wait(), 1) << program.error();
    EXPECT_TRUE(says(program.error(), "0 of 6 trials are finished: no worker is in the queue")) << program.error();
    EXPECT_FALSE(fs::exists(study.out()));
  }
  study.go_on();
  Program again(study.file(""), study.slow_words(two_workers("6")));
  EXPECT_EQ(again.wait(), 0) << again.error();
  EXPECT_TRUE(fs::exists(array_of(study, "002")));
  EXPECT_EQ(study.journal().done, 6U);
}

TEST_F(SlurmTune, AnArrayInTheQueueIsWaitedForAndNotSubmittedAgain) {
  const StudyFolder study;
  study.hold_up();
  {
    Program program(study.file(""), study.slow_words(two_workers("6")));
    ASSERT_TRUE(both_work(study)) << program.error();
    program.signal(SIGINT);
    EXPECT_EQ(program.wait(), 130) << program.error();
  }
  EXPECT_EQ(study.journal().working.size(), 2U) << "the workers go on";
  Program again(study.file(""), study.slow_words(two_workers("6")));
  ASSERT_TRUE(wait_for([&] { return says(again.error(), "waiting for the workers of job array"); })) << again.error();
  study.go_on();
  EXPECT_EQ(again.wait(), 0) << again.error();
  EXPECT_FALSE(fs::exists(array_of(study, "002")));
  EXPECT_EQ(study.journal().done, 6U);
  EXPECT_EQ(study.journal().failed, 0U);
}

TEST_F(SlurmTune, TellsWhatSbatchRefuses) {
  const StudyFolder study;
  std::vector<std::string> words = study.slow_words(two_workers("2"));
  words.insert(words.end(), {"--partition", "none"});
  Program wrong(study.file(""), words);
  EXPECT_EQ(wrong.wait(), 3);
  EXPECT_TRUE(says(wrong.error(), "invalid partition specified: none")) << wrong.error();
  Program many(study.file(""), study.slow_words({"--engine", "slurm", "--workers", "13"}));
  EXPECT_EQ(many.wait(), 2);
  EXPECT_TRUE(says(many.error(), "--workers = 13, must be at most 12: MaxArraySize of this site")) << many.error();
}

}  // namespace
}  // namespace poise::testing
