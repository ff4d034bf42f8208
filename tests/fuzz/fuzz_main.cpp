// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "fuzz/readers.h"

// The program that libFuzzer drives: poise_fuzz --reader=NAME FOLDER... (cmake/fuzz.sh).
namespace {
const poise::fuzz::Reader* reader = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  constexpr std::string_view kOption = "--reader=";
  for (int i = 1; i < *count; ++i) {
    const std::string_view word = (*arguments)[i];
    if (word.starts_with(kOption)) reader = poise::fuzz::find_reader(word.substr(kOption.size()));
    if (word == "--list") {
      for (const poise::fuzz::Reader& each : poise::fuzz::readers())
        std::printf("%.*s\n", static_cast<int>(each.name.size()), each.name.data());
      std::exit(0);
    }
  }
  if (reader == nullptr) {
    std::fputs("poise_fuzz: --reader=NAME must be one that --list shows\n", stderr);
    std::exit(2);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  reader->read({reinterpret_cast<const char*>(bytes), count});
  return 0;
}
