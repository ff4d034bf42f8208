// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "scene/temporary_folder.h"

namespace poise::testing {

/// A folder for `poise tune`, and what its journal says.
class StudyFolder {
 public:
  /// What a journal holds, by its lines alone.
  struct Journal {
    std::map<std::string, double> values;  ///< of trials that are done, by their policies
    std::size_t done = 0, failed = 0;      ///< trials; `failed` are also those that were ended and tried again
    std::size_t retried = 0;               ///< trials that were ended and tried again
    std::set<std::string> working;         ///< workers of trials that have begun and are not over
    std::set<std::string> worked;          ///< workers of trials that are done
  };

  /// Words for `poise`: a search over few bodies with these options.
  [[nodiscard]] std::vector<std::string> words(const std::vector<std::string>& options) const;
  /// The same with a program that answers as `poise compare --serve` does, by the bytes of a policy. It does not answer
  /// for a searched policy while this folder holds it up.
  [[nodiscard]] std::vector<std::string> slow_words(const std::vector<std::string>& options) const;
  void hold_up() const;
  void go_on() const;

  [[nodiscard]] Journal journal() const;
  [[nodiscard]] std::string out() const { return folder_.file("mine.json"); }
  [[nodiscard]] std::string workers() const { return out() + ".journal.workers"; }
  [[nodiscard]] std::string file(const std::string& name) const { return folder_.file(name); }
  /// Names of workers that have not left.
  [[nodiscard]] std::vector<std::string> present() const;

 private:
  TemporaryFolder folder_;
};

/// The number of the process in a worker's name.
int process_of(const std::string& worker);

/// Why no search can be made here: Python or Optuna is missing. Empty: it can.
std::string why_no_search();

}  // namespace poise::testing
