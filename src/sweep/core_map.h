// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace poise::sweep {

/// Which processors the running trials have. Invariant: a processor that a trial has alone is taken by no other.
class CoreMap {
 public:
  /// `processors` are those that may be used, by their numbers.
  explicit CoreMap(std::vector<int> processors);

  enum class Use : unsigned char {
    Alone,   ///< processors that nobody has, and that nobody gets until they are given back
    Unused,  ///< likewise, but shared with those that ask for Shared
    Shared,  ///< those that the fewest have
  };
  /// `count` processors in ascending order, or nothing as long as there are not as many. Shared and Unused take all
  /// where the machine has fewer.
  std::optional<std::vector<int>> take(std::size_t count, Use use);
  /// Gives back what take() gave.
  void give_back(const std::vector<int>& processors);
  [[nodiscard]] std::size_t size() const { return cores_.size(); }

 private:
  struct Core {
    int processor = 0;
    std::size_t users = 0;
    bool alone = false;
  };
  std::vector<Core> cores_;
};

}  // namespace poise::sweep
