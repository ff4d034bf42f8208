// SPDX-License-Identifier: MIT
#include "app/live/request_check.h"

#include <gtest/gtest.h>

#include <string>

namespace poise::app {
namespace {

const std::string kExpectedToken(32, 'a');

RequestHead head_of(std::string_view target, std::string_view host = "127.0.0.1:8080",
                    std::optional<std::string_view> origin = {}, bool upgrade = false) {
  return {"GET", target, host, origin, upgrade};
}

TEST(RequestCheck, GivesThePageToThoseWhoKnowTheToken) {
  const RequestCheck check(kExpectedToken, "127.0.0.1", 8080);
  const std::string page = "/" + kExpectedToken + "/";
  EXPECT_EQ(check.answer(head_of(page)), RequestAnswer::Page);
  EXPECT_EQ(check.answer(head_of(page, "localhost:8080")), RequestAnswer::Page);
  for (const std::string& other : {std::string("/"), std::string(""), "/" + kExpectedToken, page + "x",
                                   "/" + std::string(32, 'b') + "/", page + "?a"})
    EXPECT_EQ(check.answer(head_of(other)), RequestAnswer::NotFound) << other;
  RequestHead post = head_of(page);
  post.method = "POST";
  EXPECT_EQ(check.answer(post), RequestAnswer::WrongMethod);
}

TEST(RequestCheck, NeedsTheOriginOfItsOwnPageForASocket) {
  const RequestCheck check(kExpectedToken, "127.0.0.1", 8080);
  const std::string socket = "/" + kExpectedToken + "/socket";
  EXPECT_EQ(check.answer(head_of(socket, "127.0.0.1:8080", "http://127.0.0.1:8080", true)), RequestAnswer::Socket);
  EXPECT_EQ(check.answer(head_of(socket, "localhost:8080", "http://localhost:8080", true)), RequestAnswer::Socket);
  for (const std::string_view origin : {"http://localhost:8080", "https://127.0.0.1:8080", "http://127.0.0.1:8081",
                                        "null", "http://evil.example", "http://127.0.0.1:8080.evil.example", ""})
    EXPECT_EQ(check.answer(head_of(socket, "127.0.0.1:8080", origin, true)), RequestAnswer::Forbidden) << origin;
  EXPECT_EQ(check.answer(head_of(socket, "127.0.0.1:8080", {}, true)), RequestAnswer::Forbidden);
  EXPECT_EQ(check.answer(head_of(socket)), RequestAnswer::NotFound) << "not an upgrade";
}

TEST(RequestCheck, KnowsItsOwnNamesAlone) {
  const std::string page = "/" + kExpectedToken + "/";
  const RequestCheck near(kExpectedToken, "127.0.0.1", 8080);
  for (const std::string_view host :
       {"evil.example:8080", "127.0.0.1", "127.0.0.1:8081", "10.0.0.1:8080", "", "0.0.0.0:8080"})
    EXPECT_EQ(near.answer(head_of(page, host)), RequestAnswer::Forbidden) << host;
  const RequestCheck bound(kExpectedToken, "10.0.0.1", 8080);
  EXPECT_EQ(bound.answer(head_of(page, "10.0.0.1:8080")), RequestAnswer::Page);
  EXPECT_EQ(bound.answer(head_of(page, "10.0.0.2:8080")), RequestAnswer::Forbidden);
  const RequestCheck all(kExpectedToken, "0.0.0.0", 8080);
  EXPECT_EQ(all.answer(head_of(page, "10.0.0.2:8080")), RequestAnswer::Page);
  EXPECT_EQ(all.answer(head_of(page, "[fe80::1]:8080")), RequestAnswer::Page);
  EXPECT_EQ(all.answer(head_of(page, "evil.example:8080")), RequestAnswer::Forbidden);
}

TEST(RequestCheck, KnowsAddressesInEverySpelling) {
  const std::string page = "/" + kExpectedToken + "/";
  const RequestCheck near(kExpectedToken, "127.0.0.1", 8080);
  for (const std::string_view host :
       {"[::1]:8080", "[0:0:0:0:0:0:0:1]:8080", "[::ffff:127.0.0.1]:8080", "[::ffff:7f00:1]:8080"})
    EXPECT_EQ(near.answer(head_of(page, host)), RequestAnswer::Page) << host;
  for (const std::string_view host : {"[::ffff:7f00:2]:8080", "::1:8080", "[127.0.0.1]:8080", "[localhost]:8080",
                                      "[::1]", "[::1]:8081", "[::1:8080", "[]:8080", ":8080", "127.1:8080"})
    EXPECT_EQ(near.answer(head_of(page, host)), RequestAnswer::Forbidden) << host;
  const RequestCheck bound(kExpectedToken, "fd00::1", 8080);
  EXPECT_EQ(bound.answer(head_of(page, "[fd00:0:0::1]:8080")), RequestAnswer::Page);
  EXPECT_EQ(bound.answer(head_of(page, "[fd00::2]:8080")), RequestAnswer::Forbidden);
}

TEST(RequestCheck, NeedsNoPortWhereItIsTheOneThatBrowsersLeaveOut) {
  const std::string page = "/" + kExpectedToken + "/", socket = page + "socket";
  const RequestCheck near(kExpectedToken, "127.0.0.1", 80);
  for (const std::string_view host :
       {"127.0.0.1", "localhost", "[::1]", "127.0.0.1:80", "localhost:80", "[::1]:80", "[::ffff:7f00:1]"})
    EXPECT_EQ(near.answer(head_of(page, host)), RequestAnswer::Page) << host;
  EXPECT_EQ(near.answer(head_of(socket, "localhost", "http://localhost", true)), RequestAnswer::Socket);
  EXPECT_EQ(near.answer(head_of(socket, "localhost", "http://evil.example", true)), RequestAnswer::Forbidden);
  for (const std::string_view host :
       {"evil.example", "evil.example:80", "127.0.0.1:8080", "127.0.0.1:", "127.0.0.1:80:80", "[::1]:8080", "::1",
        "10.0.0.1", "localhost.evil.example", "", ":80"})
    EXPECT_EQ(near.answer(head_of(page, host)), RequestAnswer::Forbidden) << host;
  const RequestCheck all(kExpectedToken, "::", 80);
  EXPECT_EQ(all.answer(head_of(page, "10.0.0.2")), RequestAnswer::Page);
  EXPECT_EQ(all.answer(head_of(page, "[fe80::80]")), RequestAnswer::Page);
  for (const std::string_view host : {"evil.example", "fe80::80", "[fe80::1]:8080", "10.0.0.2:8080"})
    EXPECT_EQ(all.answer(head_of(page, host)), RequestAnswer::Forbidden) << host;
}

TEST(RequestCheck, TellsLoopbackFromOtherAddresses) {
  EXPECT_TRUE(is_loopback("127.0.0.1") && is_loopback("127.8.9.1") && is_loopback("::1"));
  EXPECT_TRUE(is_loopback("0:0:0:0:0:0:0:1") && is_loopback("::ffff:127.0.0.1"));
  EXPECT_FALSE(is_loopback("0.0.0.0") || is_loopback("128.0.0.1") || is_loopback("::") || is_loopback("localhost"));
}

TEST(PlainAddress, IsOneForAllSpellings) {
  EXPECT_EQ(plain_address("1.2.3.4"), "1.2.3.4");
  EXPECT_EQ(plain_address("0:0:0:0:0:0:0:0"), "::");
  EXPECT_EQ(plain_address("FD00::0001"), "fd00::1");
  for (const std::string_view text : {"::ffff:127.0.0.1", "::ffff:7f00:1", "0:0:0:0:0:FFFF:127.0.0.1"})
    EXPECT_EQ(plain_address(text), "127.0.0.1") << text;
  for (const std::string_view text : {"localhost", "1.2.3", "", "[::1]", "127.0.0.1:80", "::1%lo", "01.2.3.4"})
    EXPECT_FALSE(plain_address(text)) << text;
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
