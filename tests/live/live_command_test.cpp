// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <string>

#include "app/command.h"
#include "app/live/live_page.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

void write(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

TEST(LivePage, IsTheFirstThatIsThere) {
  const TemporaryFolder folder;
  write(folder.file("b"), "b <!-- poise:live -->");
  write(folder.file("c"), "c <!-- poise:live -->");
  const auto found = app::read_live_page({folder.file("a"), folder.file("b"), folder.file("c")});
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found.value().front(), 'b');
}

TEST(LivePage, IsRefusedWhereItIsNotBuiltOrAnotherPage) {
  const TemporaryFolder folder;
  const auto missing = app::read_live_page({folder.file("a"), folder.file("b")});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().message,
            "the page for live runs is not built (looked for " + folder.file("a") + ", " + folder.file("b") +
                "): cmake/build_viewer.sh in the source builds it, with node 18 or later and npm");
  write(folder.file("a"), "<!-- poise:data -->");
  const auto other = app::read_live_page({folder.file("a")});
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().message,
            folder.file("a") + ": no page for live runs: the line <!-- poise:live --> is not in it");
}

TEST(LiveCommand, RefusesBadOptions) {
  const auto refused = [](const std::vector<std::string>& more, const std::string& message) {
    std::vector<std::string> words{"live", "two-body"};
    words.insert(words.end(), more.begin(), more.end());
    const CommandResult result = poise_command(words);
    EXPECT_EQ(result.exit_code, 2) << result.error;
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
  };
  refused({"--address", "localhost"},
          "--address = localhost, must be an IPv4 or IPv6 address as a number, such as 127.0.0.1");
  refused({"--port", "65536"}, "--port = 65536, must be a whole number from 0 to 65535");
  refused({"--deadline", "0"}, "--deadline");
  refused({"--weight", "closeness=1"}, "--weight");
}

bool page_is_built() { return app::read_live_page().ok(); }

TEST(LiveCommand, SaysWhereThePageIsAndEndsAfterItsFrames) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built";
  const CommandResult result = poise_command({"live", "two-body", "--frames", "2", "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_TRUE(std::regex_match(result.out, std::regex(R"(http://127\.0\.0\.1:\d+/[0-9a-f]{32}/\n)"))) << result.out;
  EXPECT_EQ(result.error, "");
}

TEST(LiveCommand, WarnsWhereOtherMachinesCanReachIt) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built";
  const CommandResult result = poise_command({"live", "two-body", "--frames", "1", "--quiet", "--address", "0.0.0.0"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.error.find("warning: --address 0.0.0.0: whoever learns the address of the page can see and change"),
            std::string::npos)
      << result.error;
  EXPECT_EQ(result.out.rfind("http://127.0.0.1:", 0), 0U);
}

TEST(LiveCommand, PrintsTheOneSpellingOfItsAddress) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built";
  const CommandResult result =
      poise_command({"live", "two-body", "--frames", "1", "--quiet", "--address", "::ffff:127.0.0.1"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "") << "no other machine reaches it";
  EXPECT_EQ(result.out.rfind("http://127.0.0.1:", 0), 0U) << result.out;
}

TEST(LiveCommand, IsRefusedWhereTheAddressIsNotOfThisMachine) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built";
  // Of a range for documentation (RFC 5737).
  const CommandResult result = poise_command({"live", "two-body", "--quiet", "--address", "192.0.2.1"});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_NE(result.error.find("poise live: address 192.0.2.1, port 0: cannot be served: "), std::string::npos)
      << result.error;
}

TEST(LiveCommand, RefusesANumberOfBodiesWhereNothingMakesThem) {
  if (!page_is_built()) GTEST_SKIP() << "the page is not built";
  const CommandResult result = poise_command({"live", "two-body", "--bodies", "5", "--quiet"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.error, "poise live: --bodies: the scene two-body has no generators\n");
}

}  // namespace
}  // namespace poise::testing
