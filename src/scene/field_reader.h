// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "poise/types.h"
#include "scene/json_document.h"

namespace poise::io {

/// Problems of one file that are kept as text; the others are counted. Chosen.
inline constexpr std::size_t kMostProblems = 10'000;

/// Collects what is wrong with a file, so that reading can go on without a check after every field. Invariant: all()
/// holds the first kMostProblems of them in the order in which they were found.
class Problems {
 public:
  explicit Problems(std::string file) : file_(std::move(file)) {}
  /// `PATH = VALUE, RULE`.
  void refuse(const std::string& path, const JsonValue& value, const std::string& rule);
  /// `PATH: WHAT`, or `WHAT` alone for an empty path.
  void refuse(const std::string& path, const std::string& what);
  [[nodiscard]] std::optional<Error> first() const;
  [[nodiscard]] const std::vector<std::string>& all() const { return all_; }
  /// Of all problems, also those that are not kept.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// `; did you mean "x"?` or nothing. All suggestions of a file together compare at most some 30 million letters, so
  /// that thousands of wrong names are told in a second; later ones get no suggestion.
  std::string suggest(std::string_view name, const std::vector<std::string_view>& names);
  /// Whether there is work left for suggestions: enough for one pair of the longest names that are compared.
  [[nodiscard]] bool suggests() const { return letters_left_ > 100 * 100; }

 private:
  void keep(std::string message);

  std::string file_;
  std::vector<std::string> all_;
  std::size_t count_ = 0;
  std::uint64_t letters_left_ = 30'000'000;
};

/// Whether nothing was refused since it was made: rules that join several values are looked at only where each of them
/// is sound, so that one mistake is told once.
class SoundSoFar {
 public:
  explicit SoundSoFar(const Problems& problems) : problems_(problems), before_(problems.count()) {}
  explicit operator bool() const { return problems_.count() == before_; }

 private:
  const Problems& problems_;
  std::size_t before_;
};

/// Range of a number; bounds belong to it unless `open_min`.
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

/// Checks one value; on refusal the problem is noted and the target keeps what it had.
void read_number(const JsonValue& value, const std::string& path, Range range, Problems& problems, double& target);
void read_whole(const JsonValue& value, const std::string& path, std::uint64_t min, std::uint64_t max,
                Problems& problems, std::uint64_t& target);
void read_vec3(const JsonValue& value, const std::string& path, Range range, Problems& problems, Vec3& target);

/// Reads the members of one object. Members that are not in `known` are refused when it is made.
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
  /// Notes a problem if the member of an object is missing.
  const JsonValue* require(std::string_view key) const;

  // Each leaves the target alone where the member is missing, or refused.
  void number(std::string_view key, Range range, double& target) const;
  void whole(std::string_view key, std::uint64_t min, std::uint64_t max, std::uint64_t& target) const;
  void bits(std::string_view key, std::uint32_t& target) const;
  void flag(std::string_view key, bool& target) const;
  void text(std::string_view key, std::string& target) const;
  void vec3(std::string_view key, Range range, Vec3& target) const;
  void pair(std::string_view key, Range range, std::array<double, 2>& target) const;
  /// One of these texts; the index of it.
  void one_of(std::string_view key, const std::vector<std::string_view>& names, std::size_t& target) const;

 private:
  const JsonValue& value_;
  std::string path_;
  Problems& problems_;
};

/// The entry of `names` that a slip of the hand would turn into `name`, or an empty view. Ties: the first one.
/// `letters`, if given, is how many comparisons of letters it may take; what was taken is subtracted. With none left
/// the view is empty.
std::string_view nearest_name(std::string_view name, const std::vector<std::string_view>& names,
                              std::uint64_t* letters = nullptr);
/// `; did you mean "x"?` or nothing.
std::string suggestion(std::string_view name, const std::vector<std::string_view>& names);

/// `a, b or c`.
std::string listed(const std::vector<std::string_view>& names);

}  // namespace poise::io
