// SPDX-License-Identifier: MIT
#include "assets/tree/yaml_value.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <istream>
#include <optional>
#include <streambuf>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "assets/tree/tree_files.h"

namespace poise::geometry {
namespace {

using io::JsonValue;

/// Gives the parser a text, and its end already where it has read further than kMostYamlStretch since it last told of
/// something: until it knows whether a bracket opens a key, it keeps all that follows.
class BoundedText final : public std::streambuf {
 public:
  explicit BoundedText(std::string_view text) : text_(text) {
    // The base class reads through pointers to non-const.
    char* const begin = const_cast<char*>(text.data());
    setg(begin, begin, begin);
  }
  void heard() { heard_at_ = at(); }
  [[nodiscard]] bool stopped() const { return stopped_; }

 protected:
  int_type underflow() override {
    stopped_ = stopped_ || at() - heard_at_ > kMostYamlStretch;
    if (stopped_ || at() == text_.size()) return traits_type::eof();
    constexpr std::size_t kAtATime = 4096;
    setg(eback(), gptr(), gptr() + std::min(kAtATime, text_.size() - at()));
    return traits_type::to_int_type(*gptr());
  }

 private:
  [[nodiscard]] std::size_t at() const { return static_cast<std::size_t>(gptr() - eback()); }

  std::string_view text_;
  std::size_t heard_at_ = 0;
  bool stopped_ = false;
};

/// Builds a value from the events of the parser. Invariant: `open_` holds the open collections, outermost first.
class Builder final : public YAML::EventHandler {
 public:
  explicit Builder(BoundedText& text) : text_(text) {}
  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override { add({}); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override {
    if (document_.alias_line == 0) document_.alias_line = mark.line + 1;
    add({});
  }
  void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                const std::string& value) override {
    add(JsonValue::of_text(value));
  }
  void OnSequenceStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {
    open_.emplace_back();
    text_.heard();
  }
  void OnSequenceEnd() override {
    JsonValue value = JsonValue::of_array(std::move(open_.back().items));
    open_.pop_back();
    add(std::move(value));
  }
  void OnMapStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {
    open_.emplace_back().is_map = true;
    text_.heard();
  }
  void OnMapEnd() override {
    Open& top = open_.back();
    if (top.keys.size() > top.items.size()) top.items.add({});
    JsonValue value = JsonValue::of_object(std::move(top.keys), std::move(top.items));
    open_.pop_back();
    add(std::move(value));
  }
  YamlDocument take() { return std::move(document_); }

 private:
  struct Open {
    bool is_map = false;
    JsonValue::Growing keys, items;
  };

  void add(JsonValue value) {
    text_.heard();
    if (open_.empty()) {
      document_.root = std::move(value);
      return;
    }
    Open& top = open_.back();
    if (top.is_map && top.keys.size() == top.items.size()) {
      // A key that is no text is one that nothing is found by.
      top.keys.add(value.is_string() ? std::move(value) : JsonValue::of_text(""));
    } else {
      top.items.add(std::move(value));
    }
  }

  BoundedText& text_;
  std::vector<Open> open_;
  YamlDocument document_;
};

}  // namespace

Result<YamlDocument> parse_yaml(std::string_view text) {
  BoundedText bounded(text);
  std::istream stream(&bounded);
  Builder builder(bounded);
  std::optional<Error> failed;
  int line = 0;
  try {
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
  } catch (const YAML::Exception& failure) {
    line = failure.mark.line + 1;
    failed = bad_input(fmt::format("line {}: not valid YAML: {}", line, shown_text(failure.msg)));
  }
  if (bounded.stopped())
    return bad_input(
        fmt::format("more than {} bytes of one text, one collection in brackets or comments in a row, must be fewer: a "
                    "collection may "
                    "be written in lines instead of brackets",
                    kMostYamlStretch));
  if (failed) return *failed;
  return builder.take();
}

}  // namespace poise::geometry
