// SPDX-License-Identifier: MIT
#include "assets/json/json_document.h"

#include <gtest/gtest.h>

#include <string>
#include <type_traits>

namespace poise::io {
namespace {

std::string refusal(const std::string& text) {
  const Result<JsonValue> value = parse_json(text, "f.json");
  return value ? "accepted" : value.error().message;
}

TEST(JsonDocument, KeepsMembersInFileOrderAndNumbersExactly) {
  const Result<JsonValue> value =
      parse_json(R"({"b": 0.1, "a": [true, null, "x", 18446744073709551615, -3]} // end)", "f");
  ASSERT_TRUE(value) << value.error().message;
  ASSERT_EQ(value.value().keys().size(), 2U);
  EXPECT_EQ(value.value().keys()[0], "b");
  EXPECT_EQ(value.value().keys()[1], "a");
  EXPECT_EQ(value.value().find("b")->number(), 0.1);
  const JsonValue& list = *value.value().find("a");
  EXPECT_TRUE(list.items()[0].boolean());
  EXPECT_EQ(list.items()[1].kind(), JsonValue::Kind::Null);
  EXPECT_EQ(list.items()[2].text(), "x");
  EXPECT_EQ(list.items()[3].magnitude(), 18446744073709551615ULL);
  EXPECT_FALSE(list.items()[4].is_unsigned());
  EXPECT_EQ(value.value().find("c"), nullptr);
}

TEST(JsonDocument, TellsWhichNumberCannotBeRepresented) {
  EXPECT_EQ(refusal("{\"bodies\": [{}, {\n\"mass_kg\": 1e400}]}"),
            "f.json: bodies[1].mass_kg = 1e400, cannot be represented as a double (line 2)");
  EXPECT_EQ(refusal("{\"a\": [1, [2, -1e999]]}"),
            "f.json: a[1][1] = -1e999, cannot be represented as a double (line 1)");
  EXPECT_EQ(refusal("1e400"), "f.json: the file = 1e400, cannot be represented as a double (line 1)");
}

TEST(JsonDocument, TellsTheLineAndColumnOfASyntaxError) {
  EXPECT_EQ(refusal("{\n  \"a\": 1,\n  \"b\" 2\n}").substr(0, 49), "f.json: line 3, column 7: not valid JSON: syntax ");
  EXPECT_NE(refusal("{\"a\": 1}}").find("line 1, column 9"), std::string::npos);
  EXPECT_NE(refusal("{\"a\": /* never closed").find("line 1"), std::string::npos);
  EXPECT_NE(refusal("{\"a\": NaN}").find("line 1, column "), std::string::npos);
  EXPECT_NE(refusal("[1,2").find("not valid JSON"), std::string::npos);
  EXPECT_NE(refusal("").find("not valid JSON"), std::string::npos);
}

TEST(JsonDocument, RefusesAMemberThatIsGivenTwice) {
  EXPECT_EQ(refusal(R"({"a": {"b": 1, "c": 2, "b": 3}})"), "f.json: a.b is given twice");
}

TEST(JsonDocument, RefusesBrokenUtf8WithoutRepeatingIt) {
  const std::string message = refusal("{\"a\": \"\xff\xfe\"}");
  EXPECT_NE(message.find("not valid JSON"), std::string::npos);
  for (const char c : message) EXPECT_TRUE(c >= ' ' && c <= '~') << message;
}

TEST(JsonDocument, RefusesDepthBombsInsteadOfFollowingThem) {
  EXPECT_EQ(refusal(std::string(2'000'000, '[')), "f.json: nested deeper than 64 levels");
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  EXPECT_EQ(refusal(objects), "f.json: nested deeper than 64 levels");
  EXPECT_EQ(refusal(std::string(64, '[') + std::string(64, ']')), "accepted");
}

// What a collection holds in blocks is not in a vector of values: an assignment of vectors would lose it.
static_assert(std::is_nothrow_move_constructible_v<JsonValue::Growing>);
static_assert(!std::is_move_assignable_v<JsonValue::Growing> && !std::is_copy_constructible_v<JsonValue::Growing>);

TEST(JsonDocument, ShowsValuesShortAndPrintable) {
  EXPECT_EQ(in_quotes(std::string(100, 'x')).size(), 42U);
  EXPECT_EQ(in_quotes("a\nb\x7f"), "\"a?b?\"");
  EXPECT_EQ(member_path("shapes", "odd name"), "shapes[\"odd name\"]");
  EXPECT_EQ(member_path("", "dt_s"), "dt_s");
  EXPECT_EQ(shown(parse_json("[1, [2], \"x\"]", "f").value()), "[1, ..., \"x\"]");
  EXPECT_EQ(shown(parse_json("[1,2,3,4,5]", "f").value()), "a list of 5 values");
}

}  // namespace
}  // namespace poise::io
