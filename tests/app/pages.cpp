// SPDX-License-Identifier: MIT
#include "app/pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace poise::testing {

std::string embedded(const std::string& page, const std::string& id) {
  const std::size_t at = page.find(" id=\"" + id + "\">");
  if (at == std::string::npos) return "";
  const std::size_t begin = page.find('>', at) + 1;
  return page.substr(begin, page.find("</script>", begin) - begin);
}

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

void expect_no_page(const CommandResult& result, const std::string& folder) {
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.error.find("--report: the page for reports is not built (looked for "), std::string::npos)
      << result.error;
  EXPECT_FALSE(std::filesystem::exists(folder));
}

std::string hash_of_jacks(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"run",     "jacks", "--bodies", "30", "--frames", "10",
                                     "--clock", "work",  "--json",   "-",  "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const auto run = nlohmann::json::parse(poise_command(arguments).out, nullptr, false);
  EXPECT_TRUE(run.contains("state_hash"));
  return run.value("state_hash", "none");
}

}  // namespace poise::testing
