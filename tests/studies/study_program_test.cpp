// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

/// The output of a shell command, and its exit code.
std::pair<std::string, int> shell(const std::string& command) {
  std::string text;
  std::FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return {"", -1};
  std::array<char, 4096> block{};
  for (std::size_t got = 0; (got = std::fread(block.data(), 1, block.size(), pipe)) > 0;)
    text.append(block.data(), got);
  const int status = ::pclose(pipe);
  return {text, WIFEXITED(status) ? WEXITSTATUS(status) : -1};
}

TEST(StudyProgram, ListsItsStudiesUnderTheNameOfTheCommand) {
  const CommandResult result = poise_command({"study", "--help"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.out.find("Usage: poise study"), std::string::npos) << result.out;
  for (const char* name :
       {"accuracy", "levels", "trees", "cost", "kept", "compliance", "constant-time", "overload", "gaze", "population"})
    EXPECT_NE(result.out.find(name), std::string::npos) << name;
}

TEST(StudyProgram, TheCommandSaysHowItIsBuiltWhereItIsNotThere) {
  const TemporaryFolder folder;
  const std::string alone = folder.file("poise");
  std::filesystem::copy_file(POISE_COMMAND, alone);
  const auto [text, exit_code] = shell(alone + " study accuracy --help");
  EXPECT_EQ(exit_code, 2);
  EXPECT_NE(text.find("poise study: "), std::string::npos) << text;
  EXPECT_NE(text.find("poise_study"), std::string::npos) << text;
  EXPECT_EQ(text.find('\n'), text.size() - 1) << "one line: " << text;
}

TEST(StudyProgram, OfAWrongNameTellsTheNearestAndOfNoneWhereTheyAreListed) {
  const CommandResult wrong = poise_command({"study", "strip", "--quiet"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.error.find("poise study: did you mean strips instead of strip?"), std::string::npos) << wrong.error;
  const CommandResult option = poise_command({"study", "strips", "--reprot", "x"});
  EXPECT_NE(option.error.find("did you mean --report instead of --reprot?"), std::string::npos) << option.error;
  const CommandResult none = poise_command({"study"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_EQ(none.error, "poise study: the name of a study is required; poise study --help lists them\n");
}

TEST(StudyProgram, IsNoPartOfTheCommand) {
  // This text of a study is in the program of the studies, and not in `poise`.
  const std::string words = "Compare the answers of each level";
  const std::string study = std::filesystem::path(POISE_COMMAND).parent_path() / "poise-study";
  EXPECT_EQ(shell("grep -c '" + words + "' " + study).second, 0);
  EXPECT_EQ(shell("grep -c '" + words + "' " POISE_COMMAND).second, 1);
}

}  // namespace
}  // namespace poise::testing
