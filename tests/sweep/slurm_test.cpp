// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "sweep/slurm_site.h"
#include "sweep/sweep_runs.h"

namespace poise::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

class SlurmSweep : public SlurmSite {
 protected:
  static std::string job_of(const SweepFolder& sweep, const std::string& array = "001") {
    return SlurmSite::job_of(sweep.results() + "/slurm/" + array);
  }
};

TEST_F(SlurmSweep, Of40TrialsGivesTheSameAsTheLocalEngine) {
  const SweepFolder slurm(short_trials(40)), local(short_trials(40));
  const SweepFolder::Ended ended = slurm.run({"--engine", "slurm"});
  ASSERT_EQ(ended.exit_code, 0) << ended.error;
  // Number 12 is no task of a site whose MaxArraySize is 12, so 40 trials are 10 tasks of 4.
  EXPECT_TRUE(says(ended.error, "of 10 tasks, 4 trials each at most")) << ended.error;
  EXPECT_TRUE(says(ended.out, "40 done")) << ended.out;
  ASSERT_EQ(local.run({"--quiet"}).exit_code, 0);
  EXPECT_EQ(slurm.column("state_hash"), local.column("state_hash"));
  EXPECT_EQ(slurm.column("trial"), local.column("trial")) << "either engine takes the other's results";
  const std::vector<std::string> engines = slurm.column("engine");
  EXPECT_EQ(std::set<std::string>(engines.begin(), engines.end()).size(), 10U) << "of so many tasks";
  EXPECT_TRUE(engines[0].starts_with("slurm " + job_of(slurm) + "_0")) << engines[0];
  EXPECT_TRUE(slurm.files("work", "").empty());
  EXPECT_TRUE(says(slurm.run({"--engine", "slurm", "--dry-run"}).out, "40 have a result, 0 are to be run"));
}

TEST_F(SlurmSweep, SubmitsWithoutWaitingAndJoinsLater) {
  Json spec = short_trials(3);
  spec["settings"]["frames"] = 400;
  const SweepFolder sweep(spec);
  const SweepFolder::Ended first = sweep.run({"--engine", "slurm", "--no-wait"});
  EXPECT_EQ(first.exit_code, 0) << first.error;
  EXPECT_TRUE(fs::exists(sweep.results() + "/slurm/001/job"));
  // Not submitted again while it is in the queue; and not run here beside it.
  const SweepFolder::Ended second = sweep.run({"--engine", "slurm"});
  EXPECT_EQ(second.exit_code, 0) << second.error;
  EXPECT_TRUE(says(second.out, "3 done")) << second.out;
  EXPECT_FALSE(fs::exists(sweep.results() + "/slurm/002"));
}

TEST_F(SlurmSweep, TellsOfFailuresAndTimeLimits) {
  Json spec = short_trials(1);
  spec["axes"]["bodies"] = {20, 5000000};
  spec["settings"]["max_memory_mib"] = 64;
  const SweepFolder sweep(spec);
  const SweepFolder::Ended ended = sweep.run({"--engine", "slurm"});
  EXPECT_EQ(ended.exit_code, 1);
  EXPECT_TRUE(says(ended.error, "gas, bodies=5000000: failed with exit code 3; its log: ")) << ended.error;
  EXPECT_TRUE(says(ended.out, "1 done, 1 failed")) << ended.out;
  const SweepFolder::Ended refused = sweep.run({"--engine", "slurm", "--retry-failed", "--partition", "none"});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_TRUE(says(refused.error, "sbatch: ")) << refused.error;
  EXPECT_TRUE(says(refused.error, "invalid partition specified: none")) << refused.error;
}

/// Two trials, each in a task of its own, of which the second runs until it is ended.
Json one_endless_trial() {
  return {{"scenes", {"gas"}},
          {"settings", {{"clock", "work"}, {"threads", 1}, {"bodies", 200}}},
          {"axes", {{"frames", {20, 1000000}}}}};
}

/// A sweep that is under way: its first trial is done, and its second runs.
bool begun(const SweepFolder& sweep) {
  return wait_for([&] { return sweep.done() == 1 && sweep.files("logs", ".log").size() == 1; });
}

TEST_F(SlurmSweep, ACancelledArrayLeavesItsTrialsPending) {
  const SweepFolder sweep(one_endless_trial());
  Program program(sweep.path(), sweep.words({"--engine", "slurm"}));
  ASSERT_TRUE(begun(sweep)) << program.error();
  ask("scancel " + job_of(sweep));
  EXPECT_EQ(program.wait(), 1);
  EXPECT_TRUE(says(program.error(), "1 trials have no result: their process or task was ended, or the array cancelled"))
      << program.error();
  EXPECT_TRUE(says(program.out(), "1 done, 1 pending")) << program.out();
  EXPECT_EQ(sweep.column("state"), (std::vector<std::string>{"done", "pending"}));
}

TEST_F(SlurmSweep, AKilledTaskIsSubmittedAgainByTheSameCommand) {
  const SweepFolder sweep(one_endless_trial());
  Program program(sweep.path(), sweep.words({"--engine", "slurm"}));
  ASSERT_TRUE(begun(sweep)) << program.error();
  ask("scancel --signal=KILL " + job_of(sweep) + "_1");
  EXPECT_EQ(program.wait(), 1) << program.error();
  Json shorter = one_endless_trial();
  shorter["trial"] = {{"time_limit_s", 1}};
  sweep.write(shorter);
  const SweepFolder::Ended again = sweep.run({"--engine", "slurm"});
  EXPECT_EQ(again.exit_code, 1) << again.error;
  EXPECT_TRUE(says(again.error, "of 1 tasks")) << "what is done is not submitted: " << again.error;
  EXPECT_TRUE(says(again.error, "frames=1000000: was ended at its time limit of 1 s")) << again.error;
  EXPECT_EQ(sweep.column("state"), (std::vector<std::string>{"done", "timed_out"}));
}

TEST_F(SlurmSweep, ARequeuedTaskSkipsWhatIsDone) {
  Json spec = one_endless_trial();
  spec["trial"] = {{"time_limit_s", 6}};
  const SweepFolder sweep(spec);
  // Both trials in one task, so that a part of it is done when it goes back into the queue.
  Program program(sweep.path(), sweep.words({"--engine", "slurm", "--max-tasks", "1"}));
  ASSERT_TRUE(begun(sweep)) << program.error();
  const std::string done = sweep.results() + "/trials/" + sweep.files("trials", ".trial.json").at(0);
  const auto written = fs::last_write_time(done);
  ask("scontrol requeue " + job_of(sweep) + "_0");
  // A job that was put back is held for two minutes. Here it is started once its first start is over, and not within
  // the same second: Slurm would take the right to run of the second start for that of the first, which is revoked.
  ASSERT_TRUE(wait_for([&] { return says(ask("squeue --noheader --format=%T"), "PENDING") && step_daemons() == 0; }));
  ask("scontrol update JobId=" + job_of(sweep) + "_0 StartTime=now+2seconds");
  EXPECT_EQ(program.wait(), 1) << program.error();
  EXPECT_TRUE(says(program.out(), "1 done, 1 past their time limit")) << program.out();
  EXPECT_EQ(fs::last_write_time(done), written);
  EXPECT_TRUE(says(contents(sweep.results() + "/slurm/001/task-0.log"), "0 done, 0 failed, 1 past their time limit"))
      << contents(sweep.results() + "/slurm/001/task-0.log");
}

TEST_F(SlurmSweep, OnAFullDiskTheTasksEndAndTheSameCommandGoesOn) {
  const SweepFolder sweep(short_trials(30));
  fs::create_directory(sweep.results());
  // The daemons are there already, so the disk must be seen by all.
  if (::mount("tmpfs", sweep.results().c_str(), "tmpfs", 0, "size=300k") != 0)
    GTEST_SKIP() << "a disk can be mounted by root alone";
  const SweepFolder::Ended full = sweep.run({"--engine", "slurm"});
  const std::size_t done = sweep.done();
  EXPECT_NE(full.exit_code, 0) << full.error;
  EXPECT_GT(done, 0U);
  EXPECT_LT(done, 30U);
  EXPECT_EQ(::mount("tmpfs", sweep.results().c_str(), "tmpfs", MS_REMOUNT, "size=20m"), 0);
  const SweepFolder::Ended ended = sweep.run({"--engine", "slurm"});
  EXPECT_EQ(ended.exit_code, 0) << ended.error;
  EXPECT_EQ(sweep.done(), 30U);
  ::umount2(sweep.results().c_str(), MNT_DETACH);
}

TEST(SlurmSiteScript, RunsACommandWithASlurmThatEndsBehindIt) {
  const TemporaryFolder folder;
  const std::string script = POISE_SOURCE_DIR "/tests/sweep/slurm_site.sh";
  // An array of two tasks, the second of which fails: the command's exit code is that of sbatch.
  std::ofstream(folder.file("command")) << "echo $SLURM_CONF\n"
                                           "exec sbatch --wait --output=/dev/null --array=0-1 "
                                           "--wrap 'exit $((5 * SLURM_ARRAY_TASK_ID))'\n";
  const std::string line = "'" + script + "' run sh '" + folder.file("command") + "' >'" + folder.file("said") +
                           "' 2>'" + folder.file("error") + "'";
  const int status = std::system(line.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << contents(folder.file("error"));
  EXPECT_EQ(WEXITSTATUS(status), 5) << contents(folder.file("error"));
  const std::string said = contents(folder.file("said"));
  const fs::path config = said.substr(0, said.find('\n'));
  EXPECT_EQ(config.filename(), "slurm.conf");
  EXPECT_FALSE(fs::exists(config.parent_path()));
}

}  // namespace
}  // namespace poise::testing
