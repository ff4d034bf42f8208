// SPDX-License-Identifier: MIT
#include "sweep/sweep_runs.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

namespace poise::testing {

namespace fs = std::filesystem;

SweepFolder::SweepFolder(nlohmann::ordered_json spec) { write(spec); }

void SweepFolder::write(const nlohmann::ordered_json& spec) const {
  nlohmann::ordered_json whole = spec;
  whole["schema"] = "poise.sweep/1";
  std::ofstream(folder_.file("spec.json")) << whole.dump(1);
}

std::vector<std::string> SweepFolder::words(const std::vector<std::string>& options) const {
  std::vector<std::string> words{"sweep", folder_.file("spec.json"), "--out", results()};
  words.insert(words.end(), options.begin(), options.end());
  return words;
}

SweepFolder::Ended SweepFolder::run(const std::vector<std::string>& options) const {
  const TemporaryFolder said;
  Program program(said.path(), words(options));
  const int exit_code = program.wait();
  return {exit_code, program.out(), program.error()};
}

std::vector<std::string> SweepFolder::files(const std::string& in, const std::string& ending) const {
  std::vector<std::string> names;
  std::error_code failure;
  for (fs::directory_iterator entry(fs::path(results()) / in, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    const std::string name = entry->path().filename().string();
    if (name.ends_with(ending)) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

std::size_t SweepFolder::done() const {
  return files("trials", ".json").size() - files("trials", ".trial.json").size();
}

std::vector<std::string> SweepFolder::column(const std::string& name) const {
  const std::vector<std::string> rows = lines(contents(fs::path(results()) / "trials.csv"));
  std::vector<std::string> values;
  if (rows.empty()) return values;
  const std::vector<std::string> names = cells(rows[0]);
  const auto at = static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::vector<std::string> row = cells(rows[i]);
    values.push_back(at < row.size() ? row[at] : "no column " + name);
  }
  return values;
}

nlohmann::ordered_json short_trials(int count, int frames) {
  std::vector<int> bodies;
  for (int i = 0; i < count; ++i) bodies.push_back(20 + i);
  return {{"scenes", {"gas"}},
          {"settings", {{"frames", frames}, {"clock", "work"}, {"threads", 1}}},
          {"axes", {{"bodies", bodies}}}};
}

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

bool wait_for(const std::function<bool()>& condition) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point latest = Clock::now() + std::chrono::minutes(3);
  while (!condition()) {
    if (Clock::now() > latest) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace poise::testing
