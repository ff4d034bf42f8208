// SPDX-License-Identifier: MIT
#include "scene/field_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace poise::io {
namespace {

/// Number of edits from one word to the other, or `limit` if it is not below that. Two neighbouring letters in the
/// wrong order count as one edit (optimal string alignment, Damerau 1964).
std::size_t edit_distance(std::string_view a, std::string_view b, std::size_t limit) {
  std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  std::size_t least_above = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::swap(before, above);
    std::swap(above, row);
    row[0] = i + 1;
    std::size_t least = row[0];
    for (std::size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({above[j + 1] + 1, row[j] + 1, above[j] + (a[i] == b[j] ? 0U : 1U)});
      if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j]) row[j + 1] = std::min(row[j + 1], before[j - 1] + 1);
      least = std::min(least, row[j + 1]);
    }
    // No later row has a minimum below that of this row, or below one more than that of the row above.
    if (least >= limit && least_above + 1 >= limit) return limit;
    least_above = least;
  }
  return std::min(row.back(), limit);
}

}  // namespace

std::string_view nearest_name(std::string_view name, const std::vector<std::string_view>& names,
                              std::uint64_t* letters) {
  if (name.empty() || name.size() > 100) return {};
  std::string_view best;
  std::size_t limit = std::max<std::size_t>(1, name.size() / 3) + 1;
  for (const std::string_view candidate : names) {
    if (candidate.size() > 100) continue;
    const std::uint64_t work = 1 + name.size() * candidate.size();
    if (letters != nullptr && *letters < work) return {};
    if (letters != nullptr) *letters -= work;
    // A missing unit is the most common mistake: mass for mass_kg.
    const bool without_unit =
        candidate.size() > name.size() && candidate.substr(0, name.size()) == name && candidate[name.size()] == '_';
    const std::size_t distance = without_unit ? 1 : edit_distance(name, candidate, limit);
    if (distance < limit) {
      best = candidate;
      limit = distance;
    }
  }
  return best;
}

std::string suggestion(std::string_view name, const std::vector<std::string_view>& names) {
  const std::string_view near = nearest_name(name, names);
  return near.empty() ? std::string() : fmt::format("; did you mean {}?", in_quotes(near));
}

std::string listed(const std::vector<std::string_view>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += i == 0 ? "" : i + 1 == names.size() ? " or " : ", ";
    text += names[i];
  }
  return text;
}

void Problems::keep(std::string message) {
  ++count_;
  if (all_.size() < kMostProblems) all_.push_back(std::move(message));
}

std::optional<Error> Problems::first() const {
  return all_.empty() ? std::optional<Error>() : std::optional<Error>(bad_input(all_.front()));
}

std::string Problems::suggest(std::string_view name, const std::vector<std::string_view>& names) {
  if (!suggests()) return {};
  const std::string_view near = nearest_name(name, names, &letters_left_);
  return near.empty() ? std::string() : fmt::format("; did you mean {}?", in_quotes(near));
}

void Problems::refuse(const std::string& path, const JsonValue& value, const std::string& rule) {
  keep(fmt::format("{}: {} = {}, {}", file_, path, shown(value), rule));
}

void Problems::refuse(const std::string& path, const std::string& what) {
  keep(path.empty() ? fmt::format("{}: {}", file_, what) : fmt::format("{}: {}: {}", file_, path, what));
}

void read_number(const JsonValue& value, const std::string& path, Range range, Problems& problems, double& target) {
  if (value.kind() != JsonValue::Kind::Number) {
    problems.refuse(path, value, "must be a number");
  } else if (range.open_min ? !(value.number() > range.min) : !(value.number() >= range.min)) {
    problems.refuse(path, value, fmt::format("must be {} {:g}", range.open_min ? ">" : ">=", range.min));
  } else if (!(value.number() <= range.max)) {
    problems.refuse(path, value, fmt::format("must be <= {:g}", range.max));
  } else {
    target = value.number();
  }
}

void read_whole(const JsonValue& value, const std::string& path, std::uint64_t min, std::uint64_t max,
                Problems& problems, std::uint64_t& target) {
  if (value.kind() != JsonValue::Kind::Number || !value.is_unsigned() || value.magnitude() < min ||
      value.magnitude() > max) {
    problems.refuse(path, value, fmt::format("must be a whole number from {} to {}", min, max));
  } else {
    target = value.magnitude();
  }
}

void read_vec3(const JsonValue& value, const std::string& path, Range range, Problems& problems, Vec3& target) {
  if (value.kind() != JsonValue::Kind::Array || value.items().size() != 3) {
    problems.refuse(path, value, "must be a list of 3 numbers");
    return;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    read_number(value.items()[i], item_path(path, i), range, problems, target[static_cast<Eigen::Index>(i)]);
  }
}

ObjectReader::ObjectReader(const JsonValue& value, std::string path, Problems& problems,
                           std::initializer_list<std::string_view> known)
    : ObjectReader(value, std::move(path), problems, std::vector<std::string_view>(known)) {}

ObjectReader::ObjectReader(const JsonValue& value, std::string path, Problems& problems,
                           const std::vector<std::string_view>& names)
    : value_(value), path_(std::move(path)), problems_(problems) {
  if (value.kind() != JsonValue::Kind::Object) {
    if (path_.empty()) {
      problems_.refuse("", fmt::format("must be an object, is {}", shown(value)));
    } else {
      problems_.refuse(path_, value, "must be an object");
    }
    return;
  }
  const JsonValue::Keys keys = value.keys();
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::string_view key = keys[i];
    if (std::find(names.begin(), names.end(), std::string_view(key)) == names.end()) {
      problems_.refuse(this->path(key), "no such field" + problems_.suggest(key, names));
    }
  }
}

const JsonValue* ObjectReader::find(std::string_view key) const {
  return value_.kind() == JsonValue::Kind::Object ? value_.find(key) : nullptr;
}

const JsonValue* ObjectReader::require(std::string_view key) const {
  const JsonValue* found = find(key);
  if (found == nullptr && value_.kind() == JsonValue::Kind::Object)
    problems_.refuse(path(key), "missing, and it is required");
  return found;
}

void ObjectReader::number(std::string_view key, Range range, double& target) const {
  if (const JsonValue* found = find(key)) read_number(*found, path(key), range, problems_, target);
}

void ObjectReader::whole(std::string_view key, std::uint64_t min, std::uint64_t max, std::uint64_t& target) const {
  if (const JsonValue* found = find(key)) read_whole(*found, path(key), min, max, problems_, target);
}

void ObjectReader::bits(std::string_view key, std::uint32_t& target) const {
  std::uint64_t wide = target;
  whole(key, 0, 0xffffffffU, wide);
  target = static_cast<std::uint32_t>(wide);
}

void ObjectReader::flag(std::string_view key, bool& target) const {
  const JsonValue* found = find(key);
  if (found == nullptr) return;
  if (found->kind() != JsonValue::Kind::Boolean) {
    problems_.refuse(path(key), *found, "must be true or false");
  } else {
    target = found->boolean();
  }
}

void ObjectReader::text(std::string_view key, std::string& target) const {
  const JsonValue* found = find(key);
  if (found == nullptr) return;
  if (found->kind() != JsonValue::Kind::String) {
    problems_.refuse(path(key), *found, "must be a text");
  } else {
    target = found->text();
  }
}

void ObjectReader::vec3(std::string_view key, Range range, Vec3& target) const {
  if (const JsonValue* found = find(key)) read_vec3(*found, path(key), range, problems_, target);
}

void ObjectReader::pair(std::string_view key, Range range, std::array<double, 2>& target) const {
  const JsonValue* found = find(key);
  if (found == nullptr) return;
  if (found->kind() != JsonValue::Kind::Array || found->items().size() != 2) {
    problems_.refuse(path(key), *found, "must be a list of 2 numbers");
    return;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    read_number(found->items()[i], item_path(path(key), i), range, problems_, target[i]);
  }
}

void ObjectReader::one_of(std::string_view key, const std::vector<std::string_view>& names, std::size_t& target) const {
  const JsonValue* found = find(key);
  if (found == nullptr) return;
  if (found->kind() != JsonValue::Kind::String) {
    problems_.refuse(path(key), *found, "must be a text");
    return;
  }
  const auto at = std::find(names.begin(), names.end(), std::string_view(found->text()));
  if (at == names.end()) {
    problems_.refuse(path(key), *found, "must be " + listed(names) + problems_.suggest(found->text(), names));
  } else {
    target = static_cast<std::size_t>(at - names.begin());
  }
}

}  // namespace poise::io
