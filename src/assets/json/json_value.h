// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace poise::io {

/// A parsed JSON value in 24 bytes, and with it all that it contains: a text or number of more than 8 characters and
/// the members of a list or object are beside it. So a file takes at most about 16 bytes of memory for each of its own.
/// Members of an object keep the order of the file. Invariant: owns what it points to; `kind_` and `count_` say what
/// that is.
class JsonValue {
 public:
  enum class Kind : std::uint8_t { Null, Boolean, Number, String, Array, Object };
  class Items;
  class Keys;

  JsonValue() = default;
  JsonValue(JsonValue&& other) noexcept;
  JsonValue& operator=(JsonValue&& other) noexcept;
  ~JsonValue();

  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] bool is_array() const { return kind_ == Kind::Array; }
  [[nodiscard]] bool is_object() const { return kind_ == Kind::Object; }
  [[nodiscard]] bool is_number() const { return kind_ == Kind::Number; }
  [[nodiscard]] bool is_string() const { return kind_ == Kind::String; }
  [[nodiscard]] bool boolean() const { return kind_ == Kind::Boolean && flag_; }
  /// Whether it was written as an integer that magnitude() represents exactly.
  [[nodiscard]] bool is_unsigned() const { return kind_ == Kind::Number && flag_; }
  [[nodiscard]] std::uint64_t magnitude() const { return is_unsigned() ? first_.magnitude : 0; }
  /// Finite; 0 for other kinds.
  [[nodiscard]] double number() const;
  /// Of a string; for a number, the text of the file. Valid as long as the value is not moved.
  [[nodiscard]] std::string_view text() const;
  /// Of a list, or of an object parallel to keys().
  [[nodiscard]] Items items() const;
  [[nodiscard]] Keys keys() const;
  /// The member of an object, or nullptr.
  [[nodiscard]] const JsonValue* find(std::string_view key) const;

  static JsonValue of(bool value);
  static JsonValue of_text(std::string_view text);
  /// `magnitude` is given where `is_unsigned`, else `number`.
  static JsonValue of_number(std::string_view text, double number, bool is_unsigned, std::uint64_t magnitude);

  /// Collects the members of a list or object. They are never copied on the way: what it takes grows with them.
  class Growing {
   public:
    Growing() = default;
    Growing(Growing&& other) noexcept = default;
    Growing(const Growing&) = delete;
    /// Blocks that it has would be lost.
    Growing& operator=(Growing&&) = delete;
    Growing& operator=(const Growing&) = delete;
    ~Growing();
    void add(JsonValue value);
    [[nodiscard]] std::size_t size() const { return full_.size() * kBlock + last_.size(); }
    [[nodiscard]] const JsonValue& operator[](std::size_t index) const;

   private:
    friend class JsonValue;
    /// Hands its values over, as `count_` of a JsonValue describes them.
    void* take();
    std::vector<JsonValue*> full_;  ///< of kBlock values each
    std::vector<JsonValue> last_;
  };
  static JsonValue of_array(Growing items);
  /// As many keys as items.
  static JsonValue of_object(Growing keys, Growing items);

 private:
  static constexpr std::size_t kBlock = 1024;
  static constexpr std::size_t kShortText = 8;
  static const JsonValue& at(const void* list, std::size_t count, std::size_t index);
  static void free_list(void* list, std::size_t count);
  void set_text(std::string_view text);

  Kind kind_ = Kind::Null;
  bool flag_ = false;        ///< of a Boolean; of a Number is_unsigned()
  std::uint32_t count_ = 0;  ///< characters of the text, or members
  union {
    double number;            ///< of a Number without flag_
    std::uint64_t magnitude;  ///< of a Number with flag_
    void* keys;               ///< of an Object
  } first_{};
  union {
    char short_text[kShortText];
    char* long_text;  ///< of more than kShortText characters
    void* items;      ///< JsonValue[count_], or blocks of kBlock where there are more
  } second_{};
};

/// The members of a list or object, by index.
class JsonValue::Items {
 public:
  Items(const void* list, std::size_t count) : list_(list), count_(count) {}
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] const JsonValue& operator[](std::size_t index) const { return at(list_, count_, index); }

 private:
  const void* list_;
  std::size_t count_;
};

/// The keys of an object, by index.
class JsonValue::Keys {
 public:
  explicit Keys(Items keys) : keys_(keys) {}
  [[nodiscard]] std::size_t size() const { return keys_.size(); }
  [[nodiscard]] std::string_view operator[](std::size_t index) const { return keys_[index].text(); }

 private:
  Items keys_;
};

inline JsonValue::Items JsonValue::items() const {
  return is_array() || is_object() ? Items(second_.items, count_) : Items(nullptr, 0);
}
inline JsonValue::Keys JsonValue::keys() const {
  return Keys(is_object() ? Items(first_.keys, count_) : Items(nullptr, 0));
}

}  // namespace poise::io
