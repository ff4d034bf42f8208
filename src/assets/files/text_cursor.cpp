// SPDX-License-Identifier: MIT
#include "assets/files/text_cursor.h"

namespace poise::geometry {

std::string shown_word(std::string_view word) {
  constexpr std::size_t kShown = 40;
  std::string shown(word.substr(0, kShown));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return shown;
}

}  // namespace poise::geometry
