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

/// Keeps the first thing that is wrong with a file, so that reading can go on without a check after every field.
class Problems {
 public:
  explicit Problems(std::string file) : file_(std::move(file)) {}
  /// `PATH = VALUE, RULE`.
  void refuse(const std::string& path, const JsonValue& value, const std::string& rule);
  /// `PATH: WHAT`, or `WHAT` alone for an empty path.
  void refuse(const std::string& path, const std::string& what);
  [[nodiscard]] const std::optional<Error>& first() const { return first_; }

 private:
  std::string file_;
  std::optional<Error> first_;
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

  [[nodiscard]] const JsonValue* find(std::string_view key) const;
  [[nodiscard]] bool has(std::string_view key) const { return find(key) != nullptr; }
  [[nodiscard]] std::string path(std::string_view key) const { return member_path(path_, key); }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] Problems& problems() const { return problems_; }
  /// Notes a problem if the member is missing.
  const JsonValue* require(std::string_view key) const;

  // Each leaves the target alone where the member is missing, or refused.
  void number(std::string_view key, Range range, double& target) const;
  void whole(std::string_view key, std::uint64_t min, std::uint64_t max, std::uint64_t& target) const;
  void bits(std::string_view key, std::uint32_t& target) const;
  void flag(std::string_view key, bool& target) const;
  void text(std::string_view key, std::string& target) const;
  void vec3(std::string_view key, Range range, Vec3& target) const;
  void pair(std::string_view key, Range range, std::array<double, 2>& target) const;

 private:
  const JsonValue& value_;
  std::string path_;
  Problems& problems_;
};

/// The entry of `names` that a slip of the hand would turn into `name`, or an empty view. Ties: the first one.
std::string_view nearest_name(std::string_view name, const std::vector<std::string_view>& names);
/// `, did you mean "x"?` or nothing.
std::string suggestion(std::string_view name, const std::vector<std::string_view>& names);

}  // namespace poise::io
