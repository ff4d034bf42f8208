// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "sweep/sweep_runs.h"
#include "sweep/tune_study.h"

namespace poise::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class TuneWorkers : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string why = why_no_search();
    if (!why.empty()) GTEST_SKIP() << why;
  }
};

/// Runs a command to its end.
int ended(const StudyFolder& study, const std::vector<std::string>& words, std::string& error) {
  Program program(fs::path(study.out()).parent_path().string(), words);
  const int exit_code = program.wait();
  error = program.error();
  return exit_code;
}

/// Waits until so many workers each have a trial that is held up.
bool all_work(const StudyFolder& study, std::size_t workers) {
  return wait_for([&] { return study.journal().working.size() == workers; });
}

json trials_of(const StudyFolder& study) {
  return json::parse(contents(study.out()), nullptr, false).value("evidence", json{}).value("trials", json{});
}

TEST_F(TuneWorkers, DoExactlyTheTrialsThatAreAskedForWithTheValuesOfOneProcess) {
  const StudyFolder one, three;
  std::string error;
  ASSERT_EQ(ended(one, one.words({"--trials", "9"}), error), 0) << error;
  ASSERT_EQ(ended(three, three.words({"--trials", "9", "--workers", "3"}), error), 0) << error;
  EXPECT_EQ(trials_of(three), json({{"done", 9}, {"failed", 0}}));
  const StudyFolder::Journal alone = one.journal(), shared = three.journal();
  EXPECT_EQ(shared.done, 9U);
  EXPECT_EQ(shared.failed, 0U);
  std::size_t both = 0;
  for (const auto& [policy, value] : shared.values) {
    const auto same = alone.values.find(policy);
    if (same == alone.values.end()) continue;
    ++both;
    EXPECT_EQ(value, same->second) << policy;
  }
  EXPECT_GE(both, 5U) << "what is tried first is the same";
  EXPECT_TRUE(three.present().empty()) << "each has left";
}

TEST_F(TuneWorkers, BeginNoTrialThatIsOneTooMany) {
  const StudyFolder study;
  study.hold_up();
  Program program(study.file(""), study.slow_words({"--trials", "1", "--workers", "3"}));
  // The command itself is there too.
  ASSERT_TRUE(wait_for([&] { return study.present().size() == 4; })) << program.error();
  ASSERT_TRUE(all_work(study, 1)) << program.error();
  study.go_on();
  EXPECT_EQ(program.wait(), 0) << program.error();
  EXPECT_EQ(study.journal().done, 1U);
  EXPECT_EQ(study.journal().failed, 0U);
}

TEST_F(TuneWorkers, OneThatIsKilledLosesItsTrialToAnother) {
  const StudyFolder study;
  study.hold_up();
  Program program(study.file(""), study.slow_words({"--trials", "5", "--workers", "2"}));
  ASSERT_TRUE(all_work(study, 2)) << program.error();
  const std::string killed = *study.journal().working.begin();
  ASSERT_EQ(::kill(process_of(killed), SIGKILL), 0);
  study.go_on();
  EXPECT_EQ(program.wait(), 0) << program.error();
  EXPECT_TRUE(says(program.error(), "lost its worker and is tried again")) << program.error();
  EXPECT_TRUE(says(program.error(), "was ended by signal 9")) << program.error();
  const StudyFolder::Journal journal = study.journal();
  EXPECT_EQ(journal.done, 5U);
  EXPECT_EQ(journal.retried, 1U);
  EXPECT_EQ(journal.values.size(), 5U) << "the lost policy is one of the five";
  EXPECT_FALSE(journal.worked.contains(killed));
  EXPECT_EQ(trials_of(study), json({{"done", 5}, {"failed", 0}}));
}

TEST_F(TuneWorkers, WhereAllAreKilledTheSameCommandGoesOn) {
  const StudyFolder study;
  study.hold_up();
  const std::vector<std::string> words = study.slow_words({"--trials", "5", "--workers", "2"});
  {
    Program program(study.file(""), words);
    ASSERT_TRUE(all_work(study, 2)) << program.error();
    for (const std::string& worker : study.journal().working) ::kill(process_of(worker), SIGKILL);
    EXPECT_EQ(program.wait(), 1);
    EXPECT_TRUE(says(program.error(), "0 of 5 trials are finished: their workers were ended; the same command goes on"))
        << program.error();
    EXPECT_FALSE(fs::exists(study.out()));
  }
  study.go_on();
  std::string error;
  EXPECT_EQ(ended(study, words, error), 0) << error;
  EXPECT_EQ(study.journal().done, 5U);
  EXPECT_EQ(study.journal().retried, 2U);
}

TEST_F(TuneWorkers, EndWithTheCommandThatStartedThemHoweverThatEnds) {
  const StudyFolder study;
  for (const int signal : {SIGKILL, SIGTERM}) {
    study.hold_up();
    Program program(study.file(""), study.slow_words({"--trials", "5", "--workers", "2"}));
    ASSERT_TRUE(all_work(study, 2)) << program.error();
    const std::set<std::string> workers = study.journal().working;
    program.signal(signal);
    EXPECT_EQ(program.wait(), 128 + signal) << program.error();
    for (const std::string& worker : workers)
      EXPECT_TRUE(wait_for([&] { return ::kill(process_of(worker), 0) != 0; })) << worker;
    EXPECT_TRUE(study.journal().working.empty()) << "they told of their trials";
    study.go_on();
  }
}

TEST_F(TuneWorkers, ATrialThatKillsThreeWorkersHasFailed) {
  const StudyFolder study;
  const std::vector<std::string> words = study.slow_words({"--trials", "1", "--search", "frustum"});
  std::set<std::string> killed;
  for (int loss = 0; loss < 3; ++loss) {
    study.hold_up();
    Program program(study.file(""), words);
    // The trial of one that was killed counts as begun until the next one looks.
    ASSERT_TRUE(wait_for([&] {
      const std::set<std::string> working = study.journal().working;
      return working.size() == 1 && killed.insert(*working.begin()).second;
    })) << program.error();
    program.signal(SIGKILL);
    program.wait();
    study.go_on();
  }
  std::string error;
  EXPECT_EQ(ended(study, words, error), 3);
  EXPECT_TRUE(says(error, "none of 1 trials succeeded")) << error;
  EXPECT_EQ(study.journal().retried, 2U);
  EXPECT_EQ(study.journal().failed, 3U);
}

TEST_F(TuneWorkers, GoOnWithAJournalWhoseLastLineWasNeverFinished) {
  const StudyFolder study;
  std::string error;
  ASSERT_EQ(ended(study, study.slow_words({"--trials", "2"}), error), 0) << error;
  std::ofstream(study.out() + ".journal", std::ios::app) << "{\"op_code\": 6, \"worker_id\": \"a";
  ASSERT_EQ(ended(study, study.slow_words({"--trials", "4", "--workers", "2"}), error), 0) << error;
  EXPECT_EQ(study.journal().done, 4U);
}

TEST_F(TuneWorkers, AreNotStartedWithOptionsThatContradictEachOther) {
  struct Case {
    std::vector<std::string> options;
    int exit_code;
    std::string message;
  };
  const StudyFolder study;
  // A text without a line end is no journal that was cut off.
  std::ofstream(study.file("note")) << "mine";
  const std::vector<Case> cases{
      {{"--partition", "p"}, 2, "--partition needs --engine slurm"},
      {{"--sbatch=--account=me"}, 2, "--sbatch needs --engine slurm"},
      {{"--task-limit-s", "100"}, 2, "--task-limit-s needs --engine slurm"},
      {{"--engine", "cloud"}, 2, "argument --engine: invalid choice: 'cloud'"},
      {{"--workers", "0"}, 2, "argument --workers: '0', must be a whole number from 1 to 10000"},
      {{"--cues", "--workers", "2"}, 2, "--workers and --engine are of a search"},
      {{"--journal", study.file("note")}, 2, "is no journal of a study"}};
  for (const Case& c : cases) {
    std::string error;
    EXPECT_EQ(ended(study, study.words(c.options), error), c.exit_code) << error;
    EXPECT_TRUE(says(error, c.message)) << error;
  }
  EXPECT_EQ(contents(study.file("note")), "mine");
}

}  // namespace
}  // namespace poise::testing
