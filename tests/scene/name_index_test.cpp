// SPDX-License-Identifier: MIT
#include "scene/name_index.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include <fmt/format.h>

namespace poise::io {
namespace {

std::size_t comparisons = 0;

/// A name that counts how often it is compared.
struct CountedName {
  std::string text;
  friend bool operator<(const CountedName& a, const CountedName& b) { return ++comparisons, a.text < b.text; }
  friend bool operator<(const CountedName& a, std::string_view b) { return ++comparisons, a.text < b; }
  friend bool operator==(const CountedName& a, std::string_view b) { return ++comparisons, a.text == b; }
};
struct CountedShape {
  CountedName name;
};

TEST(NameIndex, FindsEachNameAndNoOther) {
  std::vector<CountedShape> shapes;
  for (int i = 0; i < 300; ++i) shapes.push_back({{fmt::format("s{}", i * 7 % 300)}});
  const NameIndex index(shapes);
  for (std::size_t i = 0; i < shapes.size(); ++i) EXPECT_EQ(index.find(shapes[i].name.text), i);
  for (const char* other : {"", "s", "s300", "t", "s1 ", "S1"}) EXPECT_EQ(index.find(other), std::nullopt) << other;
  EXPECT_EQ(NameIndex(std::vector<CountedShape>{}).find("s"), std::nullopt);
}

// One by one, 40,000 bodies of 40,000 shapes are 8e8 comparisons, which took a scene of 4 MB five seconds.
TEST(NameIndex, ComparesInProportionToTheNamesAndTheirLogarithm) {
  constexpr std::size_t kNames = 40'000;
  std::vector<CountedShape> shapes;
  for (std::size_t i = 0; i < kNames; ++i) shapes.push_back({{fmt::format("shape {}", i)}});
  comparisons = 0;
  const NameIndex index(shapes);
  for (const CountedShape& shape : shapes) ASSERT_TRUE(index.find(shape.name.text).has_value());
  EXPECT_LE(comparisons, 60 * kNames) << "16 halvings of 40,000 for each search, and a sort";
}

}  // namespace
}  // namespace poise::io
