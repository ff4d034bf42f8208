// SPDX-License-Identifier: MIT
#include "sweep/tune_study.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sweep/sweep_runs.h"

namespace poise::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Optuna's numbers for what a line of a journal says, and for the states of a trial.
enum Operation { kCreateTrial = 4, kSetState = 6, kSetUserAttribute = 8 };
enum State { kRunning = 0, kComplete = 1, kFail = 3 };

struct SeenTrial {
  std::string policy, worker;
  int state = -1;
  bool stopped = false;
  double value = 0;
};

void apply(const json& line, std::vector<SeenTrial>& trials) {
  const int operation = line.at("op_code");
  if (operation == kCreateTrial) {
    trials.emplace_back();
    // One that is queued has a state of its own.
    trials.back().state = line.value("state", static_cast<int>(kRunning));
  }
  if (operation == kSetState) {
    SeenTrial& trial = trials.at(line.at("trial_id").get<std::size_t>());
    trial.state = line.at("state");
    if (trial.state == kComplete) trial.value = line.at("values").at(0);
  }
  if (operation == kSetUserAttribute) {
    SeenTrial& trial = trials.at(line.at("trial_id").get<std::size_t>());
    const json& attribute = line.at("user_attr");
    if (attribute.contains("policy")) trial.policy = attribute.at("policy").dump();
    if (attribute.contains("worker")) trial.worker = attribute.at("worker");
    if (attribute.contains("stopped")) trial.stopped = true;
  }
}

}  // namespace

std::vector<std::string> StudyFolder::words(const std::vector<std::string>& options) const {
  std::vector<std::string> words{"tune",      "jacks", "--bodies",        "40",   "--frames", "2",
                                 "--seeds",   "1",     "--holdout-seeds", "5",    "--jobs",   "1",
                                 "--budgets", "10%",   "--rivals",        "size", "--out",    out()};
  words.insert(words.end(), options.begin(), options.end());
  return words;
}

std::vector<std::string> StudyFolder::slow_words(const std::vector<std::string>& options) const {
  const std::string program = file("pretender");
  std::ofstream(program)
      << "#!/bin/sh\n"
         "case $1 in tune|job-array) exec '" POISE_COMMAND
         "' \"$@\" ;; check) echo '{\"scene_hash\": \"s\", \"generators\": 1}'; exit ;; esac\n"
         "echo '{\"bodies\": 1, \"states\": 1, \"budgets\": [50], \"budget_unit\": \"percent\", "
         "\"machine\": {}, \"build\": {\"commit\": \"a\"}, \"scene_hash\": \"s\", \"program\": \"a\"}'\n"
         "while read -r line; do\n"
         "  while grep -qs frustum \"$line\" && [ -e '"
      << file("hold")
      << "' ]; do sleep 0.05; done\n"
         "  if [ -e \"$line\" ]; then set -- $(cksum <\"$line\"); else set -- 5; fi\n"
         "  echo \"{\\\"E_seen\\\": [[0.$1]]}\"\n"
         "done\n";
  fs::permissions(program, fs::perms::owner_all);
  std::vector<std::string> all = words({"--poise", program});
  all.insert(all.end(), options.begin(), options.end());
  return all;
}

void StudyFolder::hold_up() const { std::ofstream(file("hold")) << "x"; }

void StudyFolder::go_on() const { fs::remove(file("hold")); }

StudyFolder::Journal StudyFolder::journal() const {
  Journal journal;
  std::vector<SeenTrial> trials;
  for (const std::string& line : lines(contents(out() + ".journal"))) {
    const json read = json::parse(line, nullptr, false);
    if (!read.is_discarded()) apply(read, trials);
  }
  for (const SeenTrial& trial : trials) {
    if (trial.state == kComplete) {
      ++journal.done;
      journal.values[trial.policy] = trial.value;
      journal.worked.insert(trial.worker);
    }
    if (trial.state == kFail) ++journal.failed;
    if (trial.state == kFail && trial.stopped) ++journal.retried;
    if (trial.state == kRunning && !trial.policy.empty()) journal.working.insert(trial.worker);
  }
  return journal;
}

std::vector<std::string> StudyFolder::present() const {
  std::vector<std::string> names;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(workers(), none)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("alive-")) names.push_back(name);
  }
  return names;
}

int process_of(const std::string& worker) {
  const std::string rest = worker.substr(0, worker.rfind('-'));
  return std::stoi(rest.substr(rest.rfind('-') + 1));
}

std::string why_no_search() {
  const TemporaryFolder folder;
  Program program(folder.path().string(), {"tune", "no-such-scene", "--out", folder.file("mine.json")});
  return program.wait() == 2 ? program.error() : std::string();
}

}  // namespace poise::testing
