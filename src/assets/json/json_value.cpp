// SPDX-License-Identifier: MIT
#include "assets/json/json_value.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

namespace poise::io {

static_assert(sizeof(JsonValue) == 24, "the promise of memory in proportion to the file rests on it");

JsonValue::JsonValue(JsonValue&& other) noexcept
    : kind_(std::exchange(other.kind_, Kind::Null)),
      flag_(other.flag_),
      count_(other.count_),
      first_(other.first_),
      second_(other.second_) {}

JsonValue& JsonValue::operator=(JsonValue&& other) noexcept {
  std::swap(kind_, other.kind_);
  std::swap(flag_, other.flag_);
  std::swap(count_, other.count_);
  std::swap(first_, other.first_);
  std::swap(second_, other.second_);
  return *this;
}

JsonValue::~JsonValue() {
  if ((kind_ == Kind::String || kind_ == Kind::Number) && count_ > kShortText) delete[] second_.long_text;
  if (kind_ == Kind::Object) free_list(first_.keys, count_);
  if (kind_ == Kind::Object || kind_ == Kind::Array) free_list(second_.items, count_);
}

double JsonValue::number() const {
  if (kind_ != Kind::Number) return 0;
  return flag_ ? static_cast<double>(first_.magnitude) : first_.number;
}

std::string_view JsonValue::text() const {
  if (kind_ != Kind::String && kind_ != Kind::Number) return {};
  return {count_ > kShortText ? second_.long_text : second_.short_text, count_};
}

const JsonValue* JsonValue::find(std::string_view key) const {
  const Keys keys = this->keys();
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == key) return &items()[i];
  }
  return nullptr;
}

void JsonValue::set_text(std::string_view text) {
  count_ = static_cast<std::uint32_t>(text.size());
  char* target = second_.short_text;
  if (text.size() > kShortText) target = second_.long_text = new char[text.size()];
  if (!text.empty()) std::memcpy(target, text.data(), text.size());
}

JsonValue JsonValue::of(bool value) {
  JsonValue made;
  made.kind_ = Kind::Boolean;
  made.flag_ = value;
  return made;
}

JsonValue JsonValue::of_text(std::string_view text) {
  JsonValue made;
  made.set_text(text);
  made.kind_ = Kind::String;
  return made;
}

JsonValue JsonValue::of_number(std::string_view text, double number, bool is_unsigned, std::uint64_t magnitude) {
  JsonValue made;
  made.set_text(text);
  made.kind_ = Kind::Number;
  made.flag_ = is_unsigned;
  if (is_unsigned) {
    made.first_.magnitude = magnitude;
  } else {
    made.first_.number = number;
  }
  return made;
}

JsonValue JsonValue::of_array(Growing items) {
  JsonValue made;
  made.count_ = static_cast<std::uint32_t>(items.size());
  made.second_.items = items.take();
  made.kind_ = Kind::Array;
  return made;
}

JsonValue JsonValue::of_object(Growing keys, Growing items) {
  JsonValue made;
  made.count_ = static_cast<std::uint32_t>(items.size());
  made.first_.keys = keys.take();
  made.second_.items = items.take();
  made.kind_ = Kind::Object;
  return made;
}

const JsonValue& JsonValue::at(const void* list, std::size_t count, std::size_t index) {
  if (count <= kBlock) return static_cast<const JsonValue*>(list)[index];
  return static_cast<const JsonValue* const*>(list)[index / kBlock][index % kBlock];
}

void JsonValue::free_list(void* list, std::size_t count) {
  if (count <= kBlock) {
    delete[] static_cast<JsonValue*>(list);
    return;
  }
  auto* const blocks = static_cast<JsonValue**>(list);
  for (std::size_t i = 0; i < (count + kBlock - 1) / kBlock; ++i) delete[] blocks[i];
  delete[] blocks;
}

JsonValue::Growing::~Growing() {
  for (JsonValue* block : full_) delete[] block;
}

void JsonValue::Growing::add(JsonValue value) {
  last_.push_back(std::move(value));
  if (last_.size() < kBlock) return;
  auto block = std::make_unique<JsonValue[]>(kBlock);
  std::move(last_.begin(), last_.end(), block.get());
  full_.push_back(block.get());
  static_cast<void>(block.release());
  last_.clear();
}

const JsonValue& JsonValue::Growing::operator[](std::size_t index) const {
  return index / kBlock < full_.size() ? full_[index / kBlock][index % kBlock] : last_[index % kBlock];
}

void* JsonValue::Growing::take() {
  std::unique_ptr<JsonValue[]> rest;
  if (!last_.empty()) {
    rest = std::make_unique<JsonValue[]>(last_.size());
    std::move(last_.begin(), last_.end(), rest.get());
  }
  const std::size_t blocks = full_.size() + (last_.empty() ? 0 : 1);
  void* list = nullptr;
  if (blocks == 1) {
    list = full_.empty() ? rest.release() : full_[0];
  } else if (blocks > 1) {
    auto table = std::make_unique<JsonValue*[]>(blocks);
    std::copy(full_.begin(), full_.end(), table.get());
    if (rest) table[blocks - 1] = rest.release();
    list = table.release();
  }
  full_.clear();
  last_.clear();
  return list;
}

}  // namespace poise::io
