// SPDX-License-Identifier: MIT
#include "assets/json/json_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace poise::io {
namespace {

using ParsedJson = nlohmann::json;

/// Builds a JsonValue from the events of the parser and tracks the path of each value. Invariant: `open_` holds the
/// open containers, outermost first.
class Builder final : public nlohmann::json_sax<ParsedJson> {
 public:
  Builder(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  bool null() override { return add({}); }
  bool boolean(bool value) override { return add(JsonValue::of(value)); }
  bool number_integer(number_integer_t value) override {
    const std::string text = fmt::format("{}", value);
    return add(JsonValue::of_number(text, static_cast<double>(value), value >= 0, static_cast<std::uint64_t>(value)));
  }
  bool number_unsigned(number_unsigned_t value) override {
    return add(JsonValue::of_number(fmt::format("{}", value), 0, true, value));
  }
  bool number_float(number_float_t value, const string_t& written) override {
    // 1e3 and 600.0 are integers too; beyond 2^53 a double does not identify the written integer.
    const bool whole = !std::signbit(value) && value <= 9007199254740992.0 &&
                       value == static_cast<double>(static_cast<std::uint64_t>(value));
    return add(JsonValue::of_number(written, value, whole, whole ? static_cast<std::uint64_t>(value) : 0));
  }
  bool string(string_t& value) override { return add(JsonValue::of_text(value)); }
  bool binary(binary_t& /*value*/) override { return false; }

  bool start_object(std::size_t /*size*/) override { return open(JsonValue::Kind::Object); }
  bool start_array(std::size_t /*size*/) override { return open(JsonValue::Kind::Array); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& value) override {
    open_.back().keys.add(JsonValue::of_text(value));
    return true;
  }

  bool parse_error(std::size_t position, const std::string& token, const ParsedJson::exception& exception) override {
    const auto [line, column] = place(position);
    if (exception.id == 406) {
      error_ = bad_input(fmt::format("{}: {} = {}, cannot be represented as a double (line {})", name_, here(),
                                     printable(token), line));
      return false;
    }
    std::string what = exception.what();
    // "[...] parse error at line 3, column 5: reason": extracts the reason; the position is printed in our own format.
    const std::size_t column_at = what.find("column ");
    const std::size_t reason = column_at == std::string::npos ? what.find("] ") : what.find(": ", column_at);
    if (reason != std::string::npos) what = what.substr(reason + 2);
    error_ = bad_input(fmt::format("{}: line {}, column {}: not valid JSON: {}", name_, line, column, printable(what)));
    return false;
  }

  Result<JsonValue> take(bool done) {
    if (error_) return *error_;
    if (!done || !root_) return bad_input(fmt::format("{}: not valid JSON", name_));
    return std::move(*root_);
  }

 private:
  struct Open {
    JsonValue::Kind kind = JsonValue::Kind::Array;
    JsonValue::Growing keys, items;
  };

  bool add(JsonValue value) {
    if (open_.empty()) {
      root_ = std::move(value);
    } else {
      open_.back().items.add(std::move(value));
    }
    return true;
  }
  bool open(JsonValue::Kind kind) {
    if (open_.size() >= kMaxJsonDepth) {
      error_ = bad_input(fmt::format("{}: nested deeper than {} levels", name_, kMaxJsonDepth));
      return false;
    }
    open_.emplace_back();
    open_.back().kind = kind;
    return true;
  }
  bool close() {
    Open& top = open_.back();
    const bool is_object = top.kind == JsonValue::Kind::Object;
    if (is_object && has_twice(top.keys)) return false;
    JsonValue value = is_object ? JsonValue::of_object(std::move(top.keys), std::move(top.items))
                                : JsonValue::of_array(std::move(top.items));
    open_.pop_back();
    return add(std::move(value));
  }
  /// Refuses an object, the innermost one, that has two members of one name.
  bool has_twice(const JsonValue::Growing& keys) {
    std::vector<std::uint32_t> order(keys.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return keys[a].text() < keys[b].text(); });
    const auto twice = std::adjacent_find(
        order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return keys[a].text() == keys[b].text(); });
    if (twice == order.end()) return false;
    error_ = bad_input(
        fmt::format("{}: {} is given twice", name_, member_path(path_of(open_.size() - 1), keys[*twice].text())));
    return true;
  }

  /// Path of the container open_[depth].
  [[nodiscard]] std::string path_of(std::size_t depth) const {
    std::string path;
    for (std::size_t i = 0; i < depth; ++i) path = step_into(path, open_[i]);
    return path;
  }
  /// Path of the next value.
  [[nodiscard]] std::string here() const {
    std::string path = path_of(open_.size());
    return path.empty() ? "the file" : path;
  }
  static std::string step_into(const std::string& path, const Open& container) {
    if (container.kind == JsonValue::Kind::Array) return item_path(path, container.items.size());
    const std::size_t keys = container.keys.size();
    return keys == 0 ? path : member_path(path, container.keys[keys - 1].text());
  }
  [[nodiscard]] std::pair<std::size_t, std::size_t> place(std::size_t position) const {
    const std::string_view before = text_.substr(0, std::min(position == 0 ? 0 : position - 1, text_.size()));
    const auto line = static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n')) + 1;
    const std::size_t last = before.rfind('\n');
    return {line, last == std::string_view::npos ? before.size() + 1 : before.size() - last};
  }

  std::string_view text_;
  const std::string& name_;
  std::vector<Open> open_;
  std::optional<JsonValue> root_;
  std::optional<Error> error_;
};

bool plain_key(std::string_view key) {
  return !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

}  // namespace

Result<JsonValue> parse_json(std::string_view text, const std::string& name) {
  if (text.size() > std::numeric_limits<std::uint32_t>::max())
    return bad_input(fmt::format("{}: {} bytes of JSON, at most 4 GiB are accepted", name, text.size()));
  Builder builder(text, name);
  try {
    const bool done =
        ParsedJson::sax_parse(text.begin(), text.end(), &builder, ParsedJson::input_format_t::json, true, true);
    return builder.take(done);
  } catch (const std::exception& failure) {
    return bad_input(fmt::format("{}: not valid JSON: {}", name, printable(failure.what())));
  }
}

std::string member_path(const std::string& path, std::string_view key) {
  if (!plain_key(key)) return path + "[" + in_quotes(key) + "]";
  return path.empty() ? std::string(key) : path + "." + std::string(key);
}

std::string item_path(const std::string& path, std::size_t index) { return fmt::format("{}[{}]", path, index); }

std::string printable(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c < ' ' || c > '~') c = '?';
  }
  return out;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kShown = 40;
  if (text.size() <= kShown) return "\"" + printable(text) + "\"";
  return "\"" + printable(text.substr(0, kShown - 3)) + "...\"";
}

std::string shown(const JsonValue& value) {
  switch (value.kind()) {
    case JsonValue::Kind::Null:
      return "null";
    case JsonValue::Kind::Boolean:
      return value.boolean() ? "true" : "false";
    case JsonValue::Kind::Number:
      return printable(value.text().substr(0, 40));
    case JsonValue::Kind::String:
      return in_quotes(value.text());
    case JsonValue::Kind::Array: {
      const JsonValue::Items items = value.items();
      if (items.size() > 4) return fmt::format("a list of {} values", items.size());
      std::string list = "[";
      for (std::size_t i = 0; i < items.size(); ++i) {
        const bool nested = items[i].is_array() || items[i].is_object();
        list += (i > 0 ? ", " : "") + (nested ? "..." : shown(items[i]));
      }
      return list + "]";
    }
    case JsonValue::Kind::Object:
      return "an object";
  }
  return "";
}

}  // namespace poise::io
