// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assets/json/json_document.h"
#include "poise/result.h"
#include "poise/types.h"

namespace poise::io {

/// Most problems of one file that are stored as text; the others are counted. Chosen.
inline constexpr std::size_t kMostProblems = 10'000;

/// Collects the problems of a file, so that reading can continue without a check after every field. Invariant: all()
/// holds the first kMostProblems of them in the order in which they were found.
class Problems {
 public:
  explicit Problems(std::string file) : file_(std::move(file)) {}
  /// Adds the problem `PATH = VALUE, RULE`.
  void refuse(const std::string& path, const JsonValue& value, const std::string& rule);
  /// Adds the problem `PATH: WHAT`, or `WHAT` for an empty path.
  void refuse(const std::string& path, const std::string& what);
  [[nodiscard]] std::optional<Error> first() const;
  [[nodiscard]] const std::vector<std::string>& all() const { return all_; }
  /// Number of all problems, also those without stored text.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// `; did you mean "x"?` or nothing. All suggestions for one file together compare at most about 30 million letters,
  /// so that thousands of wrong names take at most a second; after that there are no suggestions.
  std::string suggest(std::string_view name, const std::vector<std::string_view>& names);
  /// Whether another suggestion is possible: enough comparisons are left for two names of the maximum length.
  [[nodiscard]] bool suggests() const { return letters_left_ > std::uint64_t{100} * 100; }

 private:
  void keep(std::string message);

  std::string file_;
  std::vector<std::string> all_;
  std::size_t count_ = 0;
  std::uint64_t letters_left_ = 30'000'000;
};

/// Whether nothing was refused since construction. A rule on several values is checked only if each of them is valid,
/// so that one mistake is reported once.
class SoundSoFar {
 public:
  explicit SoundSoFar(const Problems& problems) : problems_(problems), before_(problems.count()) {}
  explicit operator bool() const { return problems_.count() == before_; }

 private:
  const Problems& problems_;
  std::size_t before_;
};

/// Range of a number; both bounds are included unless `open_min` is set.
struct Range {
  double min = 0;
  double max = 0;
  bool open_min = false;
};
inline constexpr double kMaxQuantity = 1e9;  ///< chosen: squares and products of such numbers stay finite
inline constexpr Range kAnyQuantity{-kMaxQuantity, kMaxQuantity, false};
inline constexpr Range kNotNegative{0, kMaxQuantity, false};
inline constexpr Range kPositive{0, kMaxQuantity, true};
inline constexpr Range kFactor{0, 1, false};
inline constexpr Range kImportance{0, 1e6, false};  ///< as a World takes it
inline constexpr Range kTimeStep{0, 1, true};       ///< of a scene, s

/// Checks one value; on refusal the problem is added and the target is unchanged.
void read_number(const JsonValue& value, const std::string& path, Range range, Problems& problems, double& target);
void read_whole(const JsonValue& value, const std::string& path, std::uint64_t min, std::uint64_t max,
                Problems& problems, std::uint64_t& target);
void read_vec3(const JsonValue& value, const std::string& path, Range range, Problems& problems, Vec3& target);

/// Reads the members of one object. The constructor refuses members that are not in `known`.
class ObjectReader {
 public:
  ObjectReader(const JsonValue& value, std::string path, Problems& problems,
               std::initializer_list<std::string_view> known);
  ObjectReader(const JsonValue& value, std::string path, Problems& problems,
               const std::vector<std::string_view>& known);

  [[nodiscard]] const JsonValue* find(std::string_view key) const;
  [[nodiscard]] bool has(std::string_view key) const { return find(key) != nullptr; }
  [[nodiscard]] std::string path(std::string_view key) const { return member_path(path_, key); }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] Problems& problems() const { return problems_; }
  /// Adds a problem if the member of an object is missing.
  const JsonValue* require(std::string_view key) const;

  // These leave the target unchanged if the member is missing or refused.
  void number(std::string_view key, Range range, double& target) const;
  void whole(std::string_view key, std::uint64_t min, std::uint64_t max, std::uint64_t& target) const;
  void bits(std::string_view key, std::uint32_t& target) const;
  void flag(std::string_view key, bool& target) const;
  void text(std::string_view key, std::string& target) const;
  void vec3(std::string_view key, Range range, Vec3& target) const;
  void pair(std::string_view key, Range range, std::array<double, 2>& target) const;
  // The same of members that must be there.
  void require_number(std::string_view key, Range range, double& target) const {
    if (require(key) != nullptr) number(key, range, target);
  }
  void require_whole(std::string_view key, std::uint64_t min, std::uint64_t max, std::uint64_t& target) const {
    if (require(key) != nullptr) whole(key, min, max, target);
  }
  void require_flag(std::string_view key, bool& target) const {
    if (require(key) != nullptr) flag(key, target);
  }
  void require_text(std::string_view key, std::string& target) const {
    if (require(key) != nullptr) text(key, target);
  }
  /// Reads one of these texts and sets the index of it.
  void one_of(std::string_view key, const std::vector<std::string_view>& names, std::size_t& target) const;

 private:
  const JsonValue& value_;
  std::string path_;
  Problems& problems_;
};

/// The entry of `names` that is nearest to `name` by typing errors, or an empty view. Ties: the first one. `letters`,
/// if given, is the number of comparisons of letters that may be used; the used ones are subtracted. With none left the
/// result is empty.
std::string_view nearest_name(std::string_view name, const std::vector<std::string_view>& names,
                              std::uint64_t* letters = nullptr);
/// `; did you mean "x"?` or nothing.
std::string suggestion(std::string_view name, const std::vector<std::string_view>& names);

/// `a, b or c`.
std::string listed(const std::vector<std::string_view>& names);

}  // namespace poise::io
