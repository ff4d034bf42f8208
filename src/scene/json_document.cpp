// SPDX-License-Identifier: MIT
#include "scene/json_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

namespace poise::io {
namespace {

using ParsedJson = nlohmann::json;

/// Builds a JsonValue from the events of the parser and tracks the path of each value. Invariant: `open_` holds the
/// open containers, outermost first.
class Builder final : public nlohmann::json_sax<ParsedJson> {
 public:
  Builder(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  bool null() override { return add({}); }
  bool boolean(bool value) override {
    JsonValue made;
    made.kind = JsonValue::Kind::Boolean;
    made.boolean = value;
    return add(std::move(made));
  }
  bool number_integer(number_integer_t value) override {
    JsonValue made;
    made.kind = JsonValue::Kind::Number;
    made.number = static_cast<double>(value);
    made.is_unsigned = value >= 0;
    made.magnitude = value >= 0 ? static_cast<std::uint64_t>(value) : 0;
    made.text = fmt::format("{}", value);
    return add(std::move(made));
  }
  bool number_unsigned(number_unsigned_t value) override {
    JsonValue made;
    made.kind = JsonValue::Kind::Number;
    made.number = static_cast<double>(value);
    made.is_unsigned = true;
    made.magnitude = value;
    made.text = fmt::format("{}", value);
    return add(std::move(made));
  }
  bool number_float(number_float_t value, const string_t& written) override {
    JsonValue made;
    made.kind = JsonValue::Kind::Number;
    made.number = value;
    // 1e3 and 600.0 are integers too; beyond 2^53 a double does not identify the written integer.
    if (value >= 0 && value <= 9007199254740992.0 && value == static_cast<double>(static_cast<std::uint64_t>(value))) {
      made.is_unsigned = true;
      made.magnitude = static_cast<std::uint64_t>(value);
    }
    made.text = written;
    return add(std::move(made));
  }
  bool string(string_t& value) override {
    JsonValue made;
    made.kind = JsonValue::Kind::String;
    made.text = std::move(value);
    return add(std::move(made));
  }
  bool binary(binary_t& /*value*/) override { return false; }

  bool start_object(std::size_t /*size*/) override { return open(JsonValue::Kind::Object); }
  bool start_array(std::size_t /*size*/) override { return open(JsonValue::Kind::Array); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& value) override {
    Open& top = open_.back();
    if (!top.seen.insert(value).second) {
      error_ = bad_input(fmt::format("{}: {} is given twice", name_, member_path(path_of(open_.size() - 1), value)));
      return false;
    }
    top.value.keys.push_back(std::move(value));
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
    JsonValue value;
    std::set<std::string> seen;
  };

  bool add(JsonValue value) {
    if (open_.empty()) {
      root_ = std::move(value);
    } else {
      open_.back().value.items.push_back(std::move(value));
    }
    return true;
  }
  bool open(JsonValue::Kind kind) {
    if (open_.size() >= kMaxJsonDepth) {
      error_ = bad_input(fmt::format("{}: nested deeper than {} levels", name_, kMaxJsonDepth));
      return false;
    }
    open_.emplace_back();
    open_.back().value.kind = kind;
    return true;
  }
  bool close() {
    JsonValue value = std::move(open_.back().value);
    open_.pop_back();
    return add(std::move(value));
  }

  /// Path of the container open_[depth].
  [[nodiscard]] std::string path_of(std::size_t depth) const {
    std::string path;
    for (std::size_t i = 0; i < depth; ++i) path = step_into(path, open_[i].value);
    return path;
  }
  /// Path of the next value.
  [[nodiscard]] std::string here() const {
    std::string path = path_of(open_.size());
    return path.empty() ? "the file" : path;
  }
  static std::string step_into(const std::string& path, const JsonValue& container) {
    if (container.kind == JsonValue::Kind::Array) return item_path(path, container.items.size());
    return container.keys.empty() ? path : member_path(path, container.keys.back());
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

const JsonValue* JsonValue::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == key) return &items[i];
  }
  return nullptr;
}

Result<JsonValue> parse_json(std::string_view text, const std::string& name) {
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
  switch (value.kind) {
    case JsonValue::Kind::Null:
      return "null";
    case JsonValue::Kind::Boolean:
      return value.boolean ? "true" : "false";
    case JsonValue::Kind::Number:
      return printable(std::string_view(value.text).substr(0, 40));
    case JsonValue::Kind::String:
      return in_quotes(value.text);
    case JsonValue::Kind::Array: {
      if (value.items.size() > 4) return fmt::format("a list of {} values", value.items.size());
      std::string list = "[";
      for (const JsonValue& item : value.items) {
        const bool nested = item.kind == JsonValue::Kind::Array || item.kind == JsonValue::Kind::Object;
        list += (list.size() > 1 ? ", " : "") + (nested ? "..." : shown(item));
      }
      return list + "]";
    }
    case JsonValue::Kind::Object:
      return "an object";
  }
  return "";
}

}  // namespace poise::io
