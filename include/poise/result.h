// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

namespace poise {

/// Why a call was refused. The command maps these to its exit codes.
enum class ErrorKind {
  BadInput,      ///< a file, field or argument breaks a rule that the message names
  StaleHandle,   ///< the handle names something that was removed
  OutputFailed,  ///< a file could not be written; no partial file is left
  CapacityFull,  ///< a stated capacity is full; nothing was changed
  Cancelled,     ///< the caller stopped the work before it was complete
};

/// A refusal as one line of text: what was wrong, where, and the rule that it breaks, for example `pile.json:
/// bodies[3].mass_kg = -1, must be > 0`.
struct Error {
  ErrorKind kind = ErrorKind::BadInput;
  std::string message;
};

/// A value or an Error, returned by value. Invariant: holds exactly one of the two.
///
/// Nothing in the library throws across its API. Only a caller's mistake throws: value() on an error and error() on a
/// value throw std::bad_variant_access in every build (as std::expected::value() throws std::bad_expected_access; a
/// program without exceptions terminates). Use value_or() where ok() was not checked. And where the system gives no
/// more memory, std::bad_alloc does; a World that threw it in a step can only be destroyed.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

  [[nodiscard]] bool ok() const { return content_.index() == 0; }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] T& value() & { return std::get<0>(content_); }
  [[nodiscard]] const T& value() const& { return std::get<0>(content_); }
  [[nodiscard]] T&& value() && { return std::get<0>(std::move(content_)); }
  /// The value, or `otherwise` if this is an error.
  [[nodiscard]] T value_or(T otherwise) const& { return ok() ? value() : std::move(otherwise); }
  [[nodiscard]] T value_or(T otherwise) && { return ok() ? std::move(*this).value() : std::move(otherwise); }
  [[nodiscard]] const Error& error() const { return std::get<1>(content_); }

 private:
  std::variant<T, Error> content_;
};

/// The empty value of a successful call.
struct Done {};
/// The result of a call that returns no value.
using Status = Result<Done>;

/// `text` with a '?' for each control character, so that names out of files cannot break a message into lines.
inline std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }, '?');
  return text;
}

/// An Error of kind BadInput. Its message is `message` as one line.
inline Error bad_input(std::string message) { return {ErrorKind::BadInput, one_line(std::move(message))}; }

}  // namespace poise
