// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "sweep/sweep_runs.h"

namespace poise::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Processes whose command lines contain the text.
std::size_t processes_with(const std::string& text) {
  std::size_t count = 0;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc", none)) {
    if (says(contents(entry.path() / "cmdline"), text)) ++count;
  }
  return count;
}

/// Trials of which each runs until it is ended.
Json endless_trials(double time_limit_s) {
  return {{"scenes", {"gas"}},
          {"settings", {{"frames", 1000000}, {"clock", "work"}}},
          {"axes", {{"bodies", {200, 201}}}},
          {"trial", {{"time_limit_s", time_limit_s}}}};
}

TEST(Sweep, GivesTheStatesOfPoiseRun) {
  // Work is left out at the smaller budget, so that all four states differ.
  Json spec = short_trials(2);
  spec["scenes"] = {"jacks"};
  spec["axes"] = {{"bodies", {40, 50}}, {"budget_work", {10, 1000}}};
  spec["settings"]["frames"] = 70;
  spec["seeds"] = {3};
  const SweepFolder sweep(spec);
  const SweepFolder::Ended ended = sweep.run({"--quiet"});
  ASSERT_EQ(ended.exit_code, 0) << ended.error;
  EXPECT_EQ(ended.out + ended.error, "");
  const std::vector<std::string> hashes = sweep.column("state_hash");
  ASSERT_EQ(hashes.size(), 4U);
  const std::vector<std::string> bodies = sweep.column("bodies"), budgets = sweep.column("budget_work");
  for (std::size_t i = 0; i < 4; ++i) {
    const TemporaryFolder folder;
    Program run(folder.path(),
                {"run", "jacks", "--frames", "70", "--clock", "work", "--bodies", bodies[i], "--budget-work",
                 budgets[i], "--seed", "3", "--quiet", "--json", folder.file("run.json")});
    ASSERT_EQ(run.wait(), 0);
    EXPECT_EQ(Json::parse(contents(folder.file("run.json"))).at("state_hash"), hashes[i]);
  }
  EXPECT_EQ(std::set<std::string>(hashes.begin(), hashes.end()).size(), 4U);
  EXPECT_TRUE(sweep.files("work", "").empty());
  EXPECT_TRUE(sweep.files("logs", "").empty()) << "no run said anything";
}

TEST(Sweep, GivesTheSameWithAnyNumberOfWorkers) {
  const SweepFolder one(short_trials(5)), three(short_trials(5));
  ASSERT_EQ(one.run({"--workers", "1", "--quiet"}).exit_code, 0);
  ASSERT_EQ(three.run({"--workers", "3", "--quiet"}).exit_code, 0);
  EXPECT_EQ(one.column("state_hash"), three.column("state_hash"));
  EXPECT_EQ(one.column("trial"), three.column("trial"));
}

TEST(Sweep, DoesNothingTwice) {
  const SweepFolder sweep(short_trials(3));
  ASSERT_EQ(sweep.run({"--quiet"}).exit_code, 0);
  const std::vector<std::string> keys = sweep.column("trial"), seconds = sweep.column("seconds");
  fs::remove(sweep.results() + "/trials/" + keys[1] + ".json");
  // Another axis value, and the order of the members is another.
  Json more = short_trials(4);
  more["settings"] = {{"threads", 1}, {"clock", "work"}, {"frames", 10}};
  sweep.write(more);
  const SweepFolder::Ended ended = sweep.run({"--dry-run"});
  EXPECT_TRUE(says(ended.out, "2 have a result, 2 are to be run")) << ended.out;
  ASSERT_EQ(sweep.run({"--quiet"}).exit_code, 0);
  const std::vector<std::string> again = sweep.column("seconds");
  ASSERT_EQ(again.size(), 4U);
  EXPECT_EQ(again[0], seconds[0]);
  EXPECT_NE(again[1], seconds[1]) << "it was run again";
  EXPECT_EQ(again[2], seconds[2]);
  EXPECT_EQ(sweep.column("trial")[2], keys[2]);
}

TEST(Sweep, ShowsItsTrialsBeforehandAndLeavesNothing) {
  Json spec = short_trials(30);
  spec["settings"] = {{"frames", 100}, {"deadline_ms", 4}};
  spec["requirements"] = {"miss_rate < 1"};
  const SweepFolder sweep(spec);
  const SweepFolder::Ended ended = sweep.run({"--dry-run", "--workers", "1"});
  EXPECT_EQ(ended.exit_code, 0) << ended.error;
  for (const char* part : {"spec: 30 trials", "0 have a result, 30 are to be run", "about 12 s with 1 at a time",
                           "gas, bodies=20 (1 core, timed)", "and 10 more"})
    EXPECT_TRUE(says(ended.out, part)) << part << "\n" << ended.out;
  EXPECT_FALSE(fs::exists(sweep.results()));
}

TEST(Sweep, TellsOfATrialThatFailsAndGoesOn) {
  Json spec = short_trials(1);
  spec["axes"]["bodies"] = {20, 5000000, 21};
  spec["settings"]["max_memory_mib"] = 64;
  const SweepFolder sweep(spec);
  const SweepFolder::Ended ended = sweep.run({"--workers", "1"});
  EXPECT_EQ(ended.exit_code, 1);
  EXPECT_TRUE(says(ended.error, "poise sweep: gas, bodies=5000000: failed with exit code 3; its log: ")) << ended.error;
  EXPECT_TRUE(says(ended.error, "    poise run: ")) << "the end of its log: " << ended.error;
  EXPECT_TRUE(says(ended.out, "2 done, 1 failed")) << ended.out;
  EXPECT_EQ(sweep.column("state"), (std::vector<std::string>{"done", "failed", "done"}));
  EXPECT_EQ(sweep.column("exit_code"), (std::vector<std::string>{"0", "3", "0"}));
  EXPECT_EQ(sweep.files("logs", ".log").size(), 1U);
  // It is not tried again unless that is asked for.
  EXPECT_FALSE(says(sweep.run({"--workers", "1"}).error, "failed with"));
  EXPECT_TRUE(says(sweep.run({"--workers", "1", "--retry-failed"}).error, "failed with exit code 3"));
  // An engine that cannot begin takes nothing away.
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", sweep.path().c_str(), 1);
  EXPECT_EQ(sweep.run({"--engine", "slurm", "--retry-failed"}).exit_code, 3);
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(sweep.files("trials", ".trial.json").size(), 3U);
}

TEST(Sweep, SwitchesOffWhatTheSceneSwitchesOn) {
  Json spec = short_trials(1, 120);
  spec["scenes"] = {"metropolis"};
  spec["axes"] = {{"sleeping", {true, false}}};
  spec["settings"]["bodies"] = 60;
  const SweepFolder sweep(spec);
  EXPECT_EQ(sweep.run({"--workers", "1"}).exit_code, 0);
  const std::vector<std::string> slept = sweep.column("sleep.asleep_mean");
  ASSERT_EQ(slept.size(), 2U);
  EXPECT_GT(std::stod(slept[0]), 0);
  EXPECT_EQ(slept[1], "0");
}

TEST(Sweep, EndsATrialAtItsTimeLimit) {
  const SweepFolder sweep(endless_trials(0.3));
  const SweepFolder::Ended ended = sweep.run();
  EXPECT_EQ(ended.exit_code, 1);
  EXPECT_TRUE(says(ended.error, "gas, bodies=200: was ended at its time limit of 0.3 s")) << ended.error;
  EXPECT_TRUE(says(ended.out, "0 done, 2 past their time limit")) << ended.out;
  EXPECT_EQ(sweep.column("state"), (std::vector<std::string>{"timed_out", "timed_out"}));
  EXPECT_EQ(processes_with(sweep.results()), 0U);
  EXPECT_TRUE(sweep.files("work", "").empty());
  EXPECT_TRUE(says(sweep.run({"--dry-run"}).out, "2 have a result, 0 are to be run"));
  sweep.write(endless_trials(0.4));
  EXPECT_TRUE(says(sweep.run({"--dry-run"}).out, "0 have a result, 2 are to be run")) << "it has more time now";
}

TEST(Sweep, GoesOnWhereItWasKilled) {
  const SweepFolder sweep(short_trials(12, 60));
  {
    Program program(sweep.path(), sweep.words({"--workers", "2"}));
    ASSERT_TRUE(wait_for([&] { return sweep.done() >= 3 || program.ended(); }));
    program.signal(SIGKILL);
    EXPECT_EQ(program.wait(), 128 + SIGKILL) << program.error();
  }
  EXPECT_TRUE(wait_for([&] { return processes_with(sweep.results()) == 0; })) << "its trials end with it";
  const std::vector<std::string> before = sweep.files("trials", ".json");
  const std::size_t done = sweep.done();
  ASSERT_LT(done, 12U);
  const SweepFolder::Ended ended = sweep.run({"--workers", "2"});
  EXPECT_EQ(ended.exit_code, 0) << ended.error;
  EXPECT_EQ(sweep.done(), 12U);
  const SweepFolder whole(short_trials(12, 60));
  ASSERT_EQ(whole.run({"--quiet"}).exit_code, 0);
  EXPECT_EQ(sweep.column("state_hash"), whole.column("state_hash"));
  EXPECT_TRUE(sweep.files("work", "").empty()) << "what the killed one left is gone";
}

TEST(Sweep, IsEndedByASignalWithWhatIsDone) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Json spec = endless_trials(3600);
    spec["axes"]["bodies"] = {200};
    const SweepFolder sweep(spec);
    Program program(sweep.path(), sweep.words());
    ASSERT_TRUE(wait_for([&] { return processes_with(sweep.results() + "/work") > 0 || program.ended(); }));
    program.signal(signal);
    EXPECT_EQ(program.wait(), 128 + signal);
    EXPECT_TRUE(says(program.error(), "the same command goes on where this one ended")) << program.error();
    EXPECT_TRUE(says(program.out(), "0 done, 1 pending")) << program.out();
    EXPECT_EQ(processes_with(sweep.results()), 0U);
    EXPECT_EQ(sweep.column("state"), (std::vector<std::string>{"pending"}));
  }
}

TEST(Sweep, KeepsOthersOutOfItsFolder) {
  const SweepFolder sweep(endless_trials(3600));
  Program program(sweep.path(), sweep.words());
  ASSERT_TRUE(wait_for([&] { return processes_with(sweep.results() + "/work") > 0 || program.ended(); }));
  const SweepFolder::Ended second = sweep.run();
  EXPECT_EQ(second.exit_code, 3);
  EXPECT_TRUE(says(second.error, "another sweep is at work in this folder")) << second.error;
  EXPECT_TRUE(says(sweep.run({"--no-run"}).out, "0 done, 2 pending")) << "what is there may be looked at";
  program.signal(SIGTERM);
  EXPECT_EQ(program.wait(), 128 + SIGTERM);
}

TEST(Sweep, BindsEachTimedTrialToProcessorsOfItsOwn) {
  Json spec = short_trials(3, 20);
  spec["settings"] = {{"frames", 20}, {"deadline_ms", 8}};
  const SweepFolder sweep(spec);
  ASSERT_EQ(sweep.run({"--quiet"}).exit_code, 0);
  for (const std::string& file : sweep.files("trials", ".trial.json")) {
    const Json trial = Json::parse(contents(sweep.results() + "/trials/" + file));
    EXPECT_EQ(trial.at("affinity").size(), 1U);
    const std::string key = trial.at("key");
    const Json run = Json::parse(contents(sweep.results() + "/trials/" + key + ".json"));
    EXPECT_EQ(run.at("machine").at("cores"), 1) << "the run may use this one alone";
    EXPECT_EQ(run.at("threads"), 1);
    EXPECT_EQ(run.at("settings").at("time_priors_frames"), 0) << "no trial learns from another";
  }
}

TEST(Sweep, TellsInWhichCombinationsTheRequirementsDoNotHold) {
  Json spec = short_trials(3);
  // With the floor and five walls of the scene.
  spec["requirements"] = {"bodies <= 27"};
  const SweepFolder sweep(spec);
  const SweepFolder::Ended ended = sweep.run();
  EXPECT_EQ(ended.exit_code, 0) << ended.error;
  EXPECT_TRUE(says(ended.out,
                   "3 done\nbodies <= 27: the requirements hold in 2 of 3 combinations, and not in\n"
                   "  bodies=22\nresults: "))
      << ended.out;
  EXPECT_EQ(sweep.column("requirements_hold"), (std::vector<std::string>{"1", "1", "0"}));
}

TEST(Sweep, WritesAReportWhereThePageIsBuilt) {
  Json spec = short_trials(3);
  spec["axes"]["budget_work"] = {50, 500};
  spec["requirements"] = {"levels.mean >= 0"};
  spec["frontier"] = {{"largest", "bodies"}, {"against", "budget_work"}};
  const SweepFolder sweep(spec);
  const std::string folder = sweep.path() + "/report";
  const SweepFolder::Ended ended = sweep.run({"--report", folder});
  if (says(ended.error, "--report: ")) GTEST_SKIP() << ended.error;
  ASSERT_EQ(ended.exit_code, 0) << ended.error;
  EXPECT_TRUE(says(ended.out, "| gas | >= 22 | >= 22 |")) << ended.out;
  const std::string page = contents(folder + "/report.html");
  EXPECT_TRUE(says(page, "levels.mean: gas"));
  EXPECT_TRUE(says(page, "6 of 6 trials are done"));
  EXPECT_TRUE(says(page, "0 are pending; the requirements hold in 6 of 6 combinations."));
  EXPECT_TRUE(says(ended.out, "report:  " + folder + "/report.html\n")) << ended.out;
  EXPECT_TRUE(fs::exists(folder + "/frontier.svg"));
  EXPECT_TRUE(fs::exists(folder + "/levels-mean-along-bodies-gas.svg"));
  EXPECT_TRUE(fs::exists(folder + "/heat-map-levels-mean-gas.svg"));
}

/// In a name space of its own: a small disk at `folder`. Ends the new process with 77 where that is not permitted.
void mount_small_disk(const std::string& folder) {
  const bool own = ::unshare(CLONE_NEWNS) == 0 && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
  if (!own || ::mount("tmpfs", folder.c_str(), "tmpfs", 0, "size=200k") != 0) ::_exit(77);
}

// The results of 40 trials take more than 200 kB. The disk goes with the shell, which looks at it.
TEST(Sweep, OnAFullDiskEndsAndKeepsWhatIsWhole) {
  const SweepFolder sweep(short_trials(40));
  fs::create_directory(sweep.results());
  std::string line;
  for (const std::string& word : sweep.words({"--workers", "1"})) line += " '" + word + "'";
  const std::string script = "'" + std::string(POISE_COMMAND) + "'" + line + "; code=$?; cp -r '" + sweep.results() +
                             "' '" + sweep.path() + "/copy'; exit $code";
  Program shell(sweep.path(), {}, [&] {
    mount_small_disk(sweep.results());
    ::execl("/bin/sh", "sh", "-c", script.c_str(), nullptr);
  });
  const int exit_code = shell.wait();
  if (exit_code == 77) GTEST_SKIP() << "a disk can be mounted by root alone";
  EXPECT_EQ(exit_code, 4) << shell.error();
  EXPECT_TRUE(says(shell.error(), "No space left on device")) << shell.error();
  // With room it goes on, and what it had is taken over.
  fs::remove_all(sweep.results());
  fs::rename(sweep.path() + "/copy", sweep.results());
  const std::size_t done = sweep.done();
  EXPECT_GT(done, 5U);
  EXPECT_LT(done, 40U);
  const SweepFolder::Ended ended = sweep.run({"--dry-run"});
  EXPECT_TRUE(says(ended.out, std::to_string(done) + " have a result")) << ended.out;
  EXPECT_EQ(sweep.run({"--quiet"}).exit_code, 0);
  EXPECT_EQ(sweep.done(), 40U);
}

struct Refused {
  Json spec;
  std::vector<std::string> options;
  int exit_code;
  std::string message;
};

TEST(Sweep, RefusesWhatPoiseRunWouldRefuse) {
  const auto with = [](const char* member, Json value) {
    Json spec{{"scenes", {"gas"}}};
    spec[member] = std::move(value);
    return spec;
  };
  const Json good = short_trials(1);
  const std::vector<Refused> cases{
      {with("axes", {{"bodies", {5, 0}}}),
       {},
       3,
       "spec.json: axes.bodies[1]: --bodies = 0, must be a whole number from 1"},
      {with("axes", {{"policy", {"fastest"}}}), {}, 3, "axes.policy[0]: --policy: \"fastest\" must be"},
      {with("settings", {{"weight.siz", 1}}),
       {},
       3,
       "settings[\"weight.siz\"]: --weight: \"siz=1\", must be CUE=VALUE"},
      {with("settings", {{"deadline_ms", -1}}), {}, 3, "settings.deadline_ms: --deadline = -1, must be a number > 0"},
      {with("axes", {{"budget_work", {5}}}), {}, 3, "gas, budget_work=5: --budget-work needs --clock work"},
      {{{"scenes", {"two-body"}}, {"axes", {{"bodies", {5}}}}}, {}, 3, "bodies: the scene has no generators"},
      {{{"scenes", {"gass"}}}, {}, 3, "scenes[0]: gass: no scene of this name ships"},
      {{{"scenes", {"none.json"}}}, {}, 3, "none.json"},
      {with("settings", {{"policy", "none.json"}}), {}, 3, "spec.json: settings.policy = \"none.json\", "},
      {with("axes", {{"gaze", {"none.csv"}}}), {}, 3, "spec.json: axes.gaze[0] = \"none.csv\", "},
      {{{"scenes", {"gas"}}, {"settings", {{"threads", 200}}}},
       {},
       3,
       "needs 200 processors, and this process may use"},
      {good, {"--engine", "cloud"}, 2, "--engine: \"cloud\" must be local or slurm"},
      {good, {"--exclusive"}, 2, "--exclusive needs --engine slurm"},
      {good, {"--sbatch=--account=me"}, 2, "--sbatch needs --engine slurm"},
      {good, {"--engine", "slurm", "--workers", "2"}, 2, "--workers has no meaning with --engine slurm"},
      {good, {"--workers", "0"}, 2, "--workers = 0, must be a whole number from 1 to 256"},
      {good, {"--dry-run", "--no-run"}, 2, "--dry-run has no meaning with --no-run"},
      {good, {"--dry-run", "--report", "r"}, 2, "--report has no meaning with --dry-run"},
      {good, {"--no-run", "--retry-failed"}, 2, "--retry-failed has no meaning with --no-run"},
      {good, {"--task", "1"}, 2, "--batch and --task need each other"},
  };
  for (const Refused& c : cases) {
    const SweepFolder sweep(c.spec);
    const SweepFolder::Ended ended = sweep.run(c.options);
    EXPECT_EQ(ended.exit_code, c.exit_code) << c.message << "\n" << ended.error;
    EXPECT_TRUE(says(ended.error, c.message)) << c.message << "\n" << ended.error;
    EXPECT_EQ(ended.out, "") << c.message;
    EXPECT_EQ(sweep.done(), 0U);
  }
  const TemporaryFolder folder;
  Program none(folder.path(), {"sweep"});
  EXPECT_EQ(none.wait(), 2);
  EXPECT_TRUE(says(none.error(), "SPEC is required"));
  const SweepFolder sweep(short_trials(1));
  Program nowhere(folder.path(), {"sweep", sweep.words()[1], "--out", "/proc/none"});
  EXPECT_EQ(nowhere.wait(), 4);
  EXPECT_TRUE(says(nowhere.error(), "/proc/none/trials: cannot be written: ")) << nowhere.error();
  Program missing(folder.path(), {"sweep", folder.file("none.json")});
  EXPECT_EQ(missing.wait(), 3);
  EXPECT_TRUE(says(missing.error(), "none.json")) << missing.error();
}

TEST(Sweep, WithoutRunningJoinsWhatIsThere) {
  const SweepFolder sweep(short_trials(2));
  const SweepFolder::Ended none = sweep.run({"--no-run"});
  EXPECT_EQ(none.exit_code, 0) << none.error;
  EXPECT_TRUE(says(none.out, "0 done, 2 pending")) << none.out;
  EXPECT_EQ(sweep.column("state"), (std::vector<std::string>{"pending", "pending"}));
}

TEST(SweepExamples, AreAccepted) {
  std::size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(POISE_SOURCE_DIR "/examples/sweeps")) {
    const TemporaryFolder folder;
    Program program(folder.path(), {"sweep", entry.path().string(), "--dry-run", "--engine", "slurm", "--out",
                                    folder.file("results")});
    EXPECT_EQ(program.wait(), 0) << entry.path() << "\n" << program.error();
    ++count;
  }
  EXPECT_GT(count, 0U);
}

}  // namespace
}  // namespace poise::testing
