// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/program.h"
#include "scene/temporary_folder.h"

namespace poise::testing {

/// A folder with a specification, `poise sweep` of it, and what that leaves.
class SweepFolder {
 public:
  /// `spec` is completed with its schema.
  explicit SweepFolder(nlohmann::ordered_json spec);

  /// Words for `poise`: the sweep of this folder with these options.
  [[nodiscard]] std::vector<std::string> words(const std::vector<std::string>& options = {}) const;
  /// Runs it to its end.
  struct Ended {
    int exit_code = -1;
    std::string out, error;
  };
  [[nodiscard]] Ended run(const std::vector<std::string>& options = {}) const;
  void write(const nlohmann::ordered_json& spec) const;
  [[nodiscard]] std::string results() const { return folder_.file("results"); }
  [[nodiscard]] std::string path() const { return folder_.path().string(); }
  /// Names of the files in a folder of the results whose names end so, sorted.
  [[nodiscard]] std::vector<std::string> files(const std::string& in, const std::string& ending) const;
  /// Number of trials that have a result.
  [[nodiscard]] std::size_t done() const;
  /// The column of the joined CSV, a text for each trial.
  [[nodiscard]] std::vector<std::string> column(const std::string& name) const;

 private:
  TemporaryFolder folder_;
};

/// Trials of counted work that take some ten milliseconds each: `bodies` from 20 on, so many of them.
nlohmann::ordered_json short_trials(int count, int frames = 10);

bool says(const std::string& text, const std::string& part);

/// Waits for a condition, at most so long that a program that works has met it before.
bool wait_for(const std::function<bool()>& condition);

}  // namespace poise::testing
