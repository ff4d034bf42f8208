// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "fuzz/readers.h"
#include "scene/temporary_folder.h"

namespace poise::fuzz {
namespace {

namespace fs = std::filesystem;

const fs::path kSeeds = fs::path(POISE_SOURCE_DIR) / "tests/fuzz/seeds";
constexpr std::uintmax_t kMostSeedBytes = 20'000;

class Seeds : public ::testing::TestWithParam<Reader> {};

/// Seeds whose names begin with `sound` are read, those with `broken` refused; the others were found by a fuzzer.
TEST_P(Seeds, AreReadOrRefusedAsTheirNamesSay) {
  std::size_t sound = 0;
  for (const auto& entry : fs::directory_iterator(kSeeds / GetParam().name)) {
    const std::string name = entry.path().filename().string();
    SCOPED_TRACE(entry.path());
    EXPECT_LE(entry.file_size(), kMostSeedBytes);
    const bool accepted = GetParam().read(testing::contents(entry.path()));
    if (name.starts_with("sound")) {
      EXPECT_TRUE(accepted);
      ++sound;
    }
    if (name.starts_with("broken")) {
      EXPECT_FALSE(accepted);
    }
  }
  EXPECT_GE(sound, 1U) << "a fuzzer begins with something that is read";
}

TEST_P(Seeds, CutOffAnywhereAreReadOrRefused) {
  for (const auto& entry : fs::directory_iterator(kSeeds / GetParam().name)) {
    const std::string whole = testing::contents(entry.path());
    const std::size_t step = 1 + whole.size() / 500;
    for (std::size_t size = 0; size < whole.size(); size += step) GetParam().read(whole.substr(0, size));
  }
}

std::string name_of(const ::testing::TestParamInfo<Reader>& info) { return std::string(info.param.name); }

INSTANTIATE_TEST_SUITE_P(Readers, Seeds, ::testing::ValuesIn(readers().begin(), readers().end()), name_of);

}  // namespace
}  // namespace poise::fuzz
