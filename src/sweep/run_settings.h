// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assets/json/json_value.h"
#include "poise/result.h"

namespace poise::sweep {

/// One setting of a run in the form that is hashed and compared. `text` is canonical: numbers as short as they can be
/// read back from, `true` and `false`, texts as they are.
struct Setting {
  std::string name;              ///< as in a specification, e.g. `deadline_ms` or `weight.closing`
  std::string text;              ///< the value
  std::optional<double> number;  ///< where the value is a number

  friend bool operator==(const Setting& a, const Setting& b) { return a.name == b.name && a.text == b.text; }
};

/// What the values of a setting are.
enum class SettingKind : std::uint8_t {
  Number,
  Text,
  Flag,    ///< true or false; false passes nothing
  Switch,  ///< likewise, and the scene has its own: false passes --no-NAME
  NumberOrText,
  Policy,
  File
};

/// An option of `poise run` that a specification may set: all but those that name outputs, and those that the engines
/// choose themselves (--affinity).
struct RunSetting {
  std::string_view name;
  std::string_view option;
  SettingKind kind = SettingKind::Number;
};

/// All of them, in the order of `poise run --help`. `weight.CUE` is not in the list.
const std::vector<RunSetting>& run_settings();

/// The setting of this name; `weight.CUE` too. Null: there is none.
const RunSetting* find_run_setting(std::string_view name);

/// The longest text of a setting, in bytes: each trial has its own. That of the longest path of a file.
inline constexpr std::size_t kLongestSetting = 4096;

/// A value of a setting. Refused, without file and path: the rule that the value breaks by its kind alone. Ranges are
/// those of `poise run`, whose options the caller lets check them.
Result<Setting> read_setting(const RunSetting& setting, std::string_view name, const io::JsonValue& value);

/// Adds the words for `poise run` of one setting; a flag that is false adds none. Files are relative to `base`.
void add_words(const Setting& setting, const std::string& base, std::vector<std::string>& words);

/// The file that a setting names, resolved against `base`; empty where it names none.
std::string file_of(const Setting& setting, const std::string& base);

}  // namespace poise::sweep
