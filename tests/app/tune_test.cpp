// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/files/scene_files.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

std::vector<std::string> words(std::vector<std::string> first, const std::vector<std::string>& more) {
  first.insert(first.end(), more.begin(), more.end());
  return first;
}

// Two runs of few bodies: what is searched on, and held-out seeds.
std::vector<std::string> small_search(const std::vector<std::string>& more) {
  return words({"tune", "jacks", "--bodies", "40", "--frames", "2", "--seeds", "1", "--holdout-seeds", "5", "--jobs",
                "2", "--rivals", "size,oracle"},
               more);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// Whether Python and Optuna are there: the command says so itself, before it looks for scenes.
bool can_search(std::string& why) {
  const TemporaryFolder folder;
  const CommandResult result = poise_command({"tune", "no-such-scene", "--out", folder.file("mine.json")});
  why = result.error;
  return result.exit_code != 2;
}

#define POISE_SKIP_WITHOUT_OPTUNA() \
  if (std::string why; !can_search(why)) GTEST_SKIP() << why

TEST(Tune, WritesAPolicyWithItsEvidenceAndGoesOnWithItsJournal) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const std::string out = folder.file("mine.json");
  const CommandResult first = poise_command(small_search({"--trials", "2", "--out", out}));
  ASSERT_EQ(first.exit_code, 0) << first.error;
  EXPECT_NE(first.error.find("2 of 2 trials"), std::string::npos) << first.error;
  EXPECT_NE(first.out.find("| `oracle` |"), std::string::npos) << first.out;
  const CommandResult second = poise_command(small_search({"--trials", "3", "--out", out}));
  ASSERT_EQ(second.exit_code, 0) << second.error;
  EXPECT_NE(second.error.find("3 of 3 trials"), std::string::npos) << second.error;
  EXPECT_EQ(second.error.find("2 of 3 trials"), std::string::npos) << "two are in the journal: " << second.error;
  const json file = json::parse(contents(out));
  EXPECT_EQ(file.at("name"), "mine");
  const json& evidence = file.at("evidence");
  EXPECT_EQ(evidence.at("schema"), "poise.tune/1");
  EXPECT_EQ(evidence.at("trials"), json({{"done", 3}, {"failed", 0}}));
  EXPECT_EQ(evidence.at("tuning").at("runs")[0].at("seed"), 1);
  EXPECT_EQ(evidence.at("held_out_seeds").at("runs")[0].at("seed"), 5);
  const json& shipped = evidence.at("tuning").at("against")[0];
  EXPECT_EQ(shipped.at("policy"), "shipped");
  EXPECT_LE(shipped.at("low"), shipped.at("ratio"));
  EXPECT_LE(shipped.at("ratio"), shipped.at("high"));
  EXPECT_LE(shipped.at("ratio"), 1.0) << "the shipped policy is among the trials";
  for (const auto& entry : std::filesystem::directory_iterator(folder.file("")))
    EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << "nothing temporary stays";
  const CommandResult run =
      poise_command({"run", "jacks", "--bodies", "20", "--frames", "2", "--quiet", "--policy", out});
  EXPECT_EQ(run.exit_code, 0) << run.error;
}

TEST(Tune, FindsTheSameHoweverOftenItIsStoppedAndWithAnyNumberOfJobs) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const auto policy = [&](const std::string& name, const std::vector<std::string>& more) {
    const CommandResult result = poise_command(small_search(words({"--out", folder.file(name), "--quiet"}, more)));
    EXPECT_EQ(result.exit_code, 0) << result.error;
    EXPECT_EQ(result.error + result.out, "");
    return json::parse(contents(folder.file(name))).at("policy");
  };
  policy("parts.json", {"--trials", "3"});
  EXPECT_EQ(policy("parts.json", {"--trials", "6"}), policy("whole.json", {"--trials", "6", "--jobs", "1"}));
}

TEST(Tune, RefusesAJournalOfAnotherSearch) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const std::vector<std::string> rest{"--trials", "1", "--out", folder.file("mine.json")};
  ASSERT_EQ(poise_command(small_search(rest)).exit_code, 0);
  const CommandResult other = poise_command(small_search(words(rest, {"--budgets", "30%"})));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.error.find("its study has budgets = \"12.5%,25%,50%\", not \"30%\""), std::string::npos)
      << other.error;
  std::ofstream(folder.file("text")) << "no journal\n";
  const CommandResult text = poise_command(small_search(words(rest, {"--journal", folder.file("text")})));
  EXPECT_EQ(text.exit_code, 2);
  EXPECT_NE(text.error.find("--journal " + folder.file("text")), std::string::npos) << text.error;
}

// A program that answers as `poise check` and `poise compare --serve` do; to the n-th policy, whose file is $line, by
// `answer`. The seed is $4.
std::string pretender(const TemporaryFolder& folder, const std::string& answer, int generators = 1,
                      const std::string& scene_hash = "s") {
  const std::string file = folder.file("pretender");
  std::ofstream(file) << "#!/bin/sh\n"
                         "if [ $1 = check ]; then echo '{\"scene_hash\": \"s\", \"generators\": "
                      << generators
                      << "}'; exit; fi\n"
                         "echo '{\"bodies\": 1, \"states\": 1, \"budgets\": [50], \"budget_unit\": \"percent\", "
                         "\"machine\": {}, \"build\": {\"commit\": \"a\"}, \"program\": \"a\", \"scene_hash\": \""
                      << scene_hash
                      << "\"}'\n"
                         "n=0\n"
                         "while read -r line; do\n"
                         "  n=$((n + 1))\n"
                      << answer << "\ndone\n";
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  return file;
}

// It answers so many states each time, with less error for policies that have the cue `touch`.
std::string pretender_of_touch(const TemporaryFolder& folder, std::size_t states) {
  const auto all = [&](const std::string& e_seen) {
    std::string text = e_seen;
    for (std::size_t i = 1; i < states; ++i) text += "," + e_seen;
    return "echo '{\"E_seen\": [" + text + "]}'";
  };
  return pretender(folder,
                   "if grep -q '\"touch\": 1' \"$line\"; then " + all("[0.2]") + "; else " + all("[0.5]") + "; fi");
}

constexpr const char* kHalf = "echo '{\"E_seen\": [[0.5]]}'";

TEST(Tune, RefusesAJournalOfASceneThatHasChangedSince) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const std::string scene = folder.file("mine.scene.json"), out = folder.file("mine.json"), journal = out + ".journal";
  const std::string text = contents(app::find_scene("jacks").value().string());
  std::ofstream(scene) << text;
  std::vector<std::string> command = small_search({"--trials", "1", "--out", out});
  command[1] = scene;
  ASSERT_EQ(poise_command(command).exit_code, 0);
  ASSERT_EQ(poise_command(command).exit_code, 0) << "nothing has changed";
  std::ofstream(scene) << text << "\n";
  const CommandResult changed = poise_command(command);
  EXPECT_EQ(changed.exit_code, 2);
  EXPECT_NE(changed.error.find("--journal " + journal + ": the scene " + scene +
                               ", or a file that it names, has changed since its study was made; name another file"),
            std::string::npos)
      << changed.error;
  std::ofstream(scene) << text;
  const std::string study = contents(journal);
  std::ofstream(journal) << replaced(study, "\"program\": \"", "\"program\": \"other ");
  EXPECT_NE(poise_command(command).error.find("its study has program = \"other "), std::string::npos);
  for (const std::string member : {"program", "scene_hashes"}) {
    std::ofstream(journal) << replaced(study, "\"" + member + "\"", "\"commit\"");
    const CommandResult earlier = poise_command(command);
    EXPECT_EQ(earlier.exit_code, 2);
    EXPECT_NE(earlier.error.find("its study does not say its " + member + ": an earlier version has made it"),
              std::string::npos)
        << earlier.error;
  }
}

TEST(Tune, RefusesStatesOfASceneThatChangedMeanwhile) {
  const TemporaryFolder folder;
  const CommandResult result = poise_command({"tune", "jacks", "--cues", "--quiet", "--out", folder.file("c.json"),
                                              "--poise", pretender(folder, kHalf, 1, "t")});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(result.error, "poise tune: jacks: has changed since this command began\n");
}

// A run that has ended is started again, and would then answer of other states.
TEST(Tune, RefusesToMakeTheStatesOfAChangedSceneAgain) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const std::string once = "touch '" + folder.file("begun") + "'; " + kHalf + "; exit";
  const std::string hash = "'$(if [ -e '" + folder.file("begun") + "' ]; then echo t; else echo s; fi)'";
  const CommandResult result = poise_command(
      small_search({"--trials", "9", "--out", folder.file("mine.json"), "--poise", pretender(folder, once, 1, hash)}));
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.error.find("jacks: it or the program has changed since its states were made first"),
            std::string::npos)
      << result.error;
}

TEST(Tune, TellsATrialThatFailsAndGoesOn) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const std::string out = folder.file("mine.json");
  const CommandResult result =
      poise_command(small_search({"--trials", "4", "--out", out, "--poise",
                                  pretender(folder, std::string("if [ \"$n $4\" = '3 1' ]; then echo '{\"error\": "
                                                                "\"not this one\"}'; else ") +
                                                        kHalf + "; fi")}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.error.find("failed: jacks, seed 1: not this one"), std::string::npos) << result.error;
  EXPECT_EQ(json::parse(contents(out)).at("evidence").at("trials"), json({{"done", 3}, {"failed", 1}}));
}

TEST(Tune, StoppedByASignalKeepsItsJournal) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const std::vector<std::string> command = small_search({"--trials", "2", "--out", folder.file("mine.json")});
  for (const int signal : {SIGINT, SIGTERM}) {
    const CommandResult stopped = interrupted_on_terminal(command, signal);
    EXPECT_EQ(stopped.exit_code, 128 + signal) << stopped.error;
    EXPECT_NE(stopped.error.find("the same command goes on"), std::string::npos) << stopped.error;
    EXPECT_FALSE(std::filesystem::exists(folder.file("mine.json")));
  }
  EXPECT_EQ(poise_command(command).exit_code, 0);
}

TEST(Tune, MeasuresWhatEachCueIsWorthWithoutOptuna) {
  const TemporaryFolder folder;
  const std::string out = folder.file("cues.json");
  const CommandResult result = poise_command({"tune", "jacks", "--bodies", "40", "--frames", "2", "--seeds", "1",
                                              "--cues", "--budgets", "30%", "--quiet", "--out", out});
  if (result.error.find("python3-optuna") != std::string::npos) GTEST_SKIP() << result.error;
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json file = json::parse(contents(out));
  EXPECT_EQ(file.at("schema"), "poise.cues/1");
  ASSERT_GE(file.at("cues").size(), 12U);
  for (const json& row : file.at("cues")) {
    for (const char* way : {"alone", "among"}) {
      EXPECT_LE(row.at(way).at("low"), row.at(way).at("ratio")) << row;
      EXPECT_LE(row.at(way).at("ratio"), row.at(way).at("high")) << row;
    }
  }
}

TEST(Tune, SaysThatNothingIsKeptWhereThereIsNoJournal) {
  const TemporaryFolder folder;
  for (const std::string what : {"--cues", "--measure"}) {
    const CommandResult stopped = interrupted_on_terminal(
        {"tune", "jacks", "--bodies", "40", "--frames", "2", what, "--out", folder.file("mine.json")}, SIGTERM);
    EXPECT_EQ(stopped.exit_code, 128 + SIGTERM) << stopped.error;
    EXPECT_NE(stopped.error.find("stopped; nothing is kept"), std::string::npos) << stopped.error;
    EXPECT_EQ(stopped.error.find("journal"), std::string::npos) << stopped.error;
  }
}

// Whatever the states say: differences of one sign have an interval on one side of 1 however few they are.
TEST(Tune, ConcludesNothingOfACueFromFewerThanSixStates) {
  const TemporaryFolder folder;
  const std::string out = folder.file("cues.json");
  const auto measured = [&](std::size_t states) {
    const CommandResult result = poise_command(
        {"tune", "jacks", "--seeds", "1", "--cues", "--out", out, "--poise", pretender_of_touch(folder, states)});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    const std::size_t row = result.out.find("| `touch` |");
    return result.out.substr(row, result.out.find('\n', row) - row);
  };
  const auto touch = [&] {
    const json file = json::parse(contents(out));
    for (const json& row : file.at("cues"))
      if (row.at("cue") == "touch") return row;
    return json();
  };
  EXPECT_EQ(measured(6), "| `touch` | 1 | yes | 0.400 (0.400 to 0.400) | 0.400 (0.400 to 0.400) | earns |");
  EXPECT_EQ(touch().at("among").at("states"), 6);
  EXPECT_EQ(measured(5), "| `touch` | 1 | yes | 0.400 (0.400 to 0.400) | 0.400 (0.400 to 0.400) | too few states |");
  EXPECT_EQ(measured(1), "| `touch` | 1 | yes | 0.400 (-) | 0.400 (-) | too few states |");
  EXPECT_TRUE(touch().at("among").at("low").is_null());
  EXPECT_TRUE(touch().at("among").at("high").is_null());
}

TEST(Tune, ShowsNoFigureOfACueWhereNoStateCounts) {
  const TemporaryFolder folder;
  const CommandResult result = poise_command({"tune", "jacks", "--cues", "--out", folder.file("cues.json"), "--poise",
                                              pretender(folder, "echo '{\"E_seen\": [[null]]}'")});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.out.find("| `touch` | 1 | yes | - | - | - |"), std::string::npos) << result.out;
  EXPECT_EQ(result.error.find("Traceback"), std::string::npos) << result.error;
  EXPECT_TRUE(json::parse(contents(folder.file("cues.json"))).at("cues")[0].at("among").is_null());
}

TEST(Tune, MakesStatesByTheBaseAndMeasuresTheShippedPolicyBesideIt) {
  const TemporaryFolder folder;
  const std::string base = folder.file("fifo.json"), out = folder.file("rivals.json");
  std::ofstream(base) << R"({"schema": "poise.policy/1", "name": "mine", "policy": {"kind": "fifo"}})";
  const auto measured = [&](const std::vector<std::string>& more) {
    const CommandResult result = poise_command(words({"tune", "jacks", "--bodies", "40", "--frames", "2", "--seeds",
                                                      "1", "--measure", "--rivals", "fifo", "--quiet", "--out", out},
                                                     more));
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return json::parse(contents(out)).at("against_rivals");
  };
  const json shipped = measured({}), mine = measured({"--base", base});
  ASSERT_EQ(shipped.at("against").size(), 1U);
  ASSERT_EQ(mine.at("against").size(), 2U);
  EXPECT_EQ(mine.at("against")[0].at("policy"), "shipped");
  EXPECT_EQ(mine.at("against")[1].at("ratio"), 1.0) << "the base is that rival";
  EXPECT_NE(mine.at("against")[0].at("E_seen"), mine.at("E_seen"));
  EXPECT_NE(mine.at("against")[0].at("E_seen"), shipped.at("E_seen")) << "the states are those of another run";
}

TEST(Tune, CallsTheBaseOfASearchByItsName) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const std::string base = folder.file("base.json"), out = folder.file("mine.json");
  std::ofstream(base) << R"({"schema": "poise.policy/1", "name": "b", "policy": {"touch": 0}})";
  const CommandResult result = poise_command(
      small_search({"--trials", "1", "--base", base, "--out", out, "--poise", pretender_of_touch(folder, 1)}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json against = json::parse(contents(out)).at("evidence").at("tuning").at("against");
  EXPECT_EQ(against[0].at("policy"), "base");
  EXPECT_EQ(against[1].at("policy"), "shipped");
  EXPECT_EQ(against[2].at("policy"), "size");
  EXPECT_NE(result.out.find("Too few states: fewer than 6 conclude nothing."), std::string::npos) << result.out;
}

TEST(Tune, TakesOneSeedOfScenesWithoutGeneratorsAndHoldsNoneOut) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const std::string out = folder.file("mine.json");
  const CommandResult result = poise_command(
      {"tune", "jacks", "--trials", "1", "--rivals", "size", "--out", out, "--poise", pretender(folder, kHalf, 0)});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json evidence = json::parse(contents(out)).at("evidence");
  EXPECT_EQ(evidence.at("tuning").at("runs").size(), 1U);
  EXPECT_FALSE(evidence.contains("held_out_seeds"));
  EXPECT_EQ(evidence.at("without_generators"), json({"jacks"}));
  EXPECT_NE(result.out.find("Not among held-out seeds, since seeds move nothing without generators: jacks"),
            std::string::npos)
      << result.out;
  EXPECT_NE(result.error.find("jacks has no generators"), std::string::npos) << result.error;
}

TEST(Tune, RefusesSeedsThatMoveNothingAndScenesUnderTwoNames) {
  POISE_SKIP_WITHOUT_OPTUNA();
  const TemporaryFolder folder;
  const std::string jacks = app::find_scene("jacks").value().string();
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"two-body", "--seeds", "1,2"},
       "--seeds: two-body has no generators: seeds move nothing in it, must be one seed"},
      {{"two-body", "--seeds", "1,2", "--cues"}, "--seeds: two-body has no generators"},
      {{"jacks", "two-body", "--holdout-seeds", "5,6"}, "--holdout-seeds: two-body has no generators"},
      {{"jacks", "--holdout", "two-body", "--holdout-seeds", "5,6"}, "--holdout-seeds: two-body has no generators"},
      {{"two-body", "--holdout-seeds", "5"},
       "--holdout-seeds: two-body has no generators: seeds move nothing in it, and its states are those that are "
       "searched on"},
      {{"jacks", "--holdout", jacks}, "--holdout: " + jacks + " is the same scene as jacks"},
      {{"jacks", jacks, "--measure"}, "SCENE: " + jacks + " is the same scene as jacks"}};
  for (const auto& [options, message] : cases) {
    const CommandResult result = poise_command(words(words({"tune"}, options), {"--out", folder.file("mine.json")}));
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_EQ(result.error.find("poise tune: " + message), 0U) << result.error;
  }
}

TEST(Tune, RefusesABaseThatPoiseRefuses) {
  const TemporaryFolder folder;
  const std::string base = folder.file("base.json");
  const std::pair<const char*, const char*> cases[] = {
      {R"({"eccentricity": null})", "policy.eccentricity = null, must"},
      {R"({"onset": -1})", "policy.onset = -1, must"},
      {R"({"onset": "1"})", "policy.onset = \"1\", must"},
      {R"({"learning": true})", "policy.learning = true, must"},
      {R"({"kind": 3})", "policy.kind = 3, must"},
      {R"({"size": [1]})", "policy.size"}};
  for (const auto& [policy, message] : cases) {
    std::ofstream(base) << R"({"schema": "poise.policy/1", "name": "b", "policy": )" << policy << "}";
    const CommandResult result = poise_command({"tune", "jacks", "--bodies", "20", "--frames", "1", "--seeds", "1",
                                                "--cues", "--quiet", "--base", base, "--out", folder.file("c.json")});
    EXPECT_EQ(result.exit_code, 3) << result.error;
    EXPECT_EQ(result.error.find("poise tune: " + base + ": " + message), 0U) << result.error;
  }
}

TEST(Tune, MeasuresAPolicyAgainstItsRivals) {
  const TemporaryFolder folder;
  const std::string out = folder.file("rivals.json");
  const CommandResult result = poise_command({"tune", "jacks", "--bodies", "40", "--frames", "2", "--seeds", "1,2",
                                              "--measure", "--rivals", "perceptual,fifo", "--quiet", "--out", out});
  if (result.error.find("python3-optuna") != std::string::npos) GTEST_SKIP() << result.error;
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json measured = json::parse(contents(out)).at("against_rivals");
  EXPECT_EQ(measured.at("runs").size(), 2U);
  EXPECT_EQ(measured.at("against")[0].at("ratio"), 1.0) << "the base is the shipped policy";
  EXPECT_EQ(measured.at("against")[1].at("policy"), "fifo");
  EXPECT_EQ(measured.at("against")[1].at("by_budget").size(), 3U);
}

TEST(Tune, RefusesWhatItCannotDo) {
  const TemporaryFolder folder;
  const std::string out = folder.file("mine.json");
  struct Case {
    std::vector<std::string> options;
    int exit_code;
    std::string message;
  };
  std::ofstream(folder.file("list.json")) << "[]";
  std::ofstream(folder.file("nan.json")) << R"({"policy": {"size": 1e999}})";
  const std::vector<Case> cases = {
      {{"--trials", "0"}, 2, "argument --trials: '0', must be a whole number from 1 to 100000"},
      {{"--jobs", "many"}, 2, "argument --jobs: 'many', must be a whole number from 1 to 256"},
      {{"--seeds", "1,-2"}, 2, "argument --seeds: '-2', must be a whole number from 0"},
      {{"--seeds", "1,1"}, 2, "argument --seeds: '1,1', must not name a seed twice"},
      {{"--seeds", "1,11"}, 2, "--holdout-seeds: 11 is searched on"},
      {{"--search", "speed"}, 2, "argument --search: 'speed', must be of frustum, size"},
      {{"--search", "size,size"}, 2, "argument --search: 'size,size', must not name a field twice"},
      {{"--holdout", "jacks"}, 2, "--holdout: jacks is searched on"},
      {{"--holdout", "pile", "pile"}, 2, "--holdout: pile is given twice"},
      {{"--history", "2", "--rivals", "oracle"}, 2, "--rivals: oracle knows one frame"},
      {{"--journal", out}, 2, "--journal and --out are the same file"},
      {{"--cues", "--measure"}, 2, "not allowed with argument"},
      {{"--speed", "2"}, 2, "unrecognized arguments: --speed"},
      {{"--out", "/no-such-folder/mine.json"}, 4, "/no-such-folder/mine.json: cannot be written"},
      {{"--out", folder.file("")}, 2, "is a folder"},
      {{"--base", folder.file("list.json"), "--out", folder.file("list.json")},
       2,
       "list.json: would overwrite the file that is read as --base"},
      {{"--journal", "/dev/null"}, 2, "--journal /dev/null: must be a file"},
      {{"--out", "/dev/null"}, 2, "--out /dev/null: is no file, so --journal must say"},
      {{"--name", "\xff"}, 2, "--name: must be UTF-8"},
      {{"--base", folder.file("none.json")}, 3, "none.json: No such file"},
      {{"--base", folder.file("list.json")}, 3, "list.json: must be a policy file (poise.policy/1)"},
      {{"--base", folder.file("nan.json")}, 3, "nan.json: must be a policy file (poise.policy/1)"},
      {{"--cues", "--budgets", "101%"}, 2, "--budgets: \"101%\", must be"},
      {{"--cues", "--from", "-1"}, 2, "--from"},
      {{"--measure", "--rivals", "best"}, 3, "jacks, seed 1: \"best\", must be of perceptual, fifo"}};
  for (const Case& c : cases) {
    const CommandResult result =
        poise_command(words({"tune", "jacks", "--bodies", "20", "--frames", "1", "--out", out}, c.options));
    if (result.error.find("python3-optuna") != std::string::npos) GTEST_SKIP() << result.error;
    EXPECT_EQ(result.exit_code, c.exit_code) << c.message << "\n" << result.error;
    EXPECT_TRUE(result.error.starts_with("poise tune: ")) << result.error;
    EXPECT_NE(result.error.find(c.message), std::string::npos) << result.error;
    EXPECT_FALSE(std::filesystem::exists(out)) << c.message;
  }
  EXPECT_NE(poise_command({"tune", "jacks"}).error.find("required: --out"), std::string::npos);
  const CommandResult scene = poise_command({"tune", "no-such-scene", "--cues", "--out", out});
  EXPECT_EQ(scene.exit_code, 3);
  EXPECT_NE(scene.error.find("no-such-scene: no scene of this name ships"), std::string::npos) << scene.error;
}

TEST(Tune, SaysWhatToInstallWhereOptunaIsMissing) {
  const TemporaryFolder folder;
  const std::string python = folder.file("python");
  // Without the folders of packages.
  std::ofstream(python) << "#!/bin/sh\nexec python3 -S \"$@\"\n";
  std::filesystem::permissions(python, std::filesystem::perms::owner_all);
  ::setenv("POISE_PYTHON", python.c_str(), 1);
  const CommandResult missing = poise_command(small_search({"--trials", "1", "--out", folder.file("mine.json")}));
  ::setenv("POISE_PYTHON", folder.file("none").c_str(), 1);
  const CommandResult no_python = poise_command(small_search({"--trials", "1", "--out", folder.file("mine.json")}));
  ::unsetenv("POISE_PYTHON");
  for (const CommandResult& result : {missing, no_python}) {
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.error.find("install the Debian package python3-optuna"), std::string::npos) << result.error;
  }
}

}  // namespace
}  // namespace poise::testing
