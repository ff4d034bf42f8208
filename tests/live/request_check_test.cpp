// SPDX-License-Identifier: MIT
#include "app/live/request_check.h"

#include <gtest/gtest.h>

#include <string>

namespace poise::app {
namespace {

const std::string kExpectedToken(32, 'a');

RequestHead head_of(std::string_view target, std::string_view host = "127.0.0.1:80",
                    std::optional<std::string_view> origin = {}, bool upgrade = false) {
  return {"GET", target, host, origin, upgrade};
}

TEST(RequestCheck, GivesThePageToThoseWhoKnowTheToken) {
  const RequestCheck check(kExpectedToken, "127.0.0.1", 80);
  const std::string page = "/" + kExpectedToken + "/";
  EXPECT_EQ(check.answer(head_of(page)), RequestAnswer::Page);
  EXPECT_EQ(check.answer(head_of(page, "localhost:80")), RequestAnswer::Page);
  for (const std::string& other : {std::string("/"), std::string(""), "/" + kExpectedToken, page + "x",
                                   "/" + std::string(32, 'b') + "/", page + "?a"})
    EXPECT_EQ(check.answer(head_of(other)), RequestAnswer::NotFound) << other;
  RequestHead post = head_of(page);
  post.method = "POST";
  EXPECT_EQ(check.answer(post), RequestAnswer::WrongMethod);
}

TEST(RequestCheck, NeedsTheOriginOfItsOwnPageForASocket) {
  const RequestCheck check(kExpectedToken, "127.0.0.1", 80);
  const std::string socket = "/" + kExpectedToken + "/socket";
  EXPECT_EQ(check.answer(head_of(socket, "127.0.0.1:80", "http://127.0.0.1:80", true)), RequestAnswer::Socket);
  EXPECT_EQ(check.answer(head_of(socket, "localhost:80", "http://localhost:80", true)), RequestAnswer::Socket);
  for (const std::string_view origin : {"http://localhost:80", "https://127.0.0.1:80", "http://127.0.0.1:81", "null",
                                        "http://evil.example", "http://127.0.0.1:80.evil.example", ""})
    EXPECT_EQ(check.answer(head_of(socket, "127.0.0.1:80", origin, true)), RequestAnswer::Forbidden) << origin;
  EXPECT_EQ(check.answer(head_of(socket, "127.0.0.1:80", {}, true)), RequestAnswer::Forbidden);
  EXPECT_EQ(check.answer(head_of(socket)), RequestAnswer::NotFound) << "not an upgrade";
}

TEST(RequestCheck, KnowsItsOwnNamesAlone) {
  const std::string page = "/" + kExpectedToken + "/";
  const RequestCheck near(kExpectedToken, "127.0.0.1", 80);
  for (const std::string_view host : {"evil.example:80", "127.0.0.1", "127.0.0.1:81", "10.0.0.1:80", "", "0.0.0.0:80"})
    EXPECT_EQ(near.answer(head_of(page, host)), RequestAnswer::Forbidden) << host;
  const RequestCheck bound(kExpectedToken, "10.0.0.1", 80);
  EXPECT_EQ(bound.answer(head_of(page, "10.0.0.1:80")), RequestAnswer::Page);
  EXPECT_EQ(bound.answer(head_of(page, "10.0.0.2:80")), RequestAnswer::Forbidden);
  const RequestCheck all(kExpectedToken, "0.0.0.0", 80);
  EXPECT_EQ(all.answer(head_of(page, "10.0.0.2:80")), RequestAnswer::Page);
  EXPECT_EQ(all.answer(head_of(page, "[fe80::1]:80")), RequestAnswer::Page);
  EXPECT_EQ(all.answer(head_of(page, "evil.example:80")), RequestAnswer::Forbidden);
}

TEST(RequestCheck, TellsLoopbackFromOtherAddresses) {
  EXPECT_TRUE(is_loopback("127.0.0.1") && is_loopback("127.8.9.1") && is_loopback("::1"));
  EXPECT_FALSE(is_loopback("0.0.0.0") || is_loopback("128.0.0.1") || is_loopback("::") || is_loopback("localhost"));
  EXPECT_TRUE(is_address("1.2.3.4") && is_address("::1"));
  EXPECT_FALSE(is_address("localhost") || is_address("1.2.3") || is_address(""));
}

TEST(RandomToken, Has128BitsAndIsAnotherOneEachTime) {
  const Result<std::string> a = random_token(), b = random_token();
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a.value().size(), 32U);
  EXPECT_EQ(a.value().find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(a.value(), b.value());
}

}  // namespace
}  // namespace poise::app
