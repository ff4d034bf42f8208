// SPDX-License-Identifier: MIT
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>

namespace poise::geometry {

/// The name that a file has before it gets its own: `.NAME.N.part` in the same folder, N from 0 to 99, or none. Whoever
/// writes such a file holds a lock on it (flock), which the system ends with the program: one without a lock was left
/// by a program that was killed, and the next that writes the same file takes its name or removes it.
///
/// Functions return 0 or the error number.
class PartFile {
 public:
  /// Opens a file for writing that will be `target`. With `hidden` it has no name where the system permits that;
  /// otherwise it keeps clear of files that killed programs left, as long as there are numbers.
  int open(const std::filesystem::path& target, bool hidden, mode_t mode, int& descriptor);
  /// Gives the open file the name `target`, in place of the file that has it.
  int rename_to(const std::filesystem::path& target, int descriptor);
  /// Removes the name, if there is one.
  void remove();
  /// Whether a file name is that of a part.
  static bool is_part(std::string_view name);
  /// Removes a part that no living program holds.
  static void remove_one_if_stale(const std::filesystem::path& part);
  /// Removes the files that killed programs left for `target`.
  static void remove_stale(const std::filesystem::path& target);

 private:
  int take_name(const std::filesystem::path& target, bool replace_stale, int descriptor);
  int create(const std::filesystem::path& target, bool replace_stale, mode_t mode, int& descriptor);

  std::filesystem::path name_;  ///< empty: none
};

}  // namespace poise::geometry
