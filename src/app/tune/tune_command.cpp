// SPDX-License-Identifier: MIT
#include "app/tune/tune_command.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "app/process/exit_codes.h"
#include "app/process/program_beside.h"
#include "app/process/refusal.h"

namespace poise::app {
namespace {

// Installed beside the scenes; else where it was built from.
std::filesystem::path search_program(const std::filesystem::path& program) {
  const std::array<std::filesystem::path, 3> folders{program.parent_path().parent_path() / "share" / "poise" / "tune",
                                                     POISE_TUNE_SOURCE_DIR, POISE_TUNE_INSTALL_DIR};
  for (const std::filesystem::path& folder : folders) {
    std::error_code failure;
    if (std::filesystem::exists(folder / "tune.py", failure)) return folder / "tune.py";
  }
  return {};
}

}  // namespace

void add_tune_command(CLI::App& app) {
  app.add_subcommand("tune", "Search the weights of a policy on some scenes, and measure it on others (by Optuna)");
}

int start_tune(int argc, char** argv) {
  const Result<std::filesystem::path> beside = program_beside("poise");
  if (!beside) return refuse("tune", beside.error());
  std::error_code failure;
  std::string self = std::filesystem::read_symlink("/proc/self/exe", failure);
  std::string search = search_program(beside.value());
  if (search.empty()) return refuse("tune", kExitBadUsage, "share/poise/tune/tune.py is not there");
  const char* const named = std::getenv("POISE_PYTHON");
  std::vector<std::string> pythons{"/usr/bin/python3", "python3"};
  if (named != nullptr && *named != '\0') pythons = {named};
  // No compiled files beside the program: its folder may belong to root.
  std::string no_cache = "-B";
  std::string option = "--poise";
  std::vector<char*> words{nullptr, no_cache.data(), search.data(), option.data(), self.data()};
  words.insert(words.end(), argv + 2, argv + argc);
  words.push_back(nullptr);
  for (std::string& python : pythons) {
    words[0] = python.data();
    ::execvp(python.c_str(), words.data());
  }
  return refuse("tune", kExitBadUsage,
                pythons.back() + ": " + std::strerror(errno) +
                    "; the search needs Python 3 and Optuna: install the Debian package python3-optuna");
}

}  // namespace poise::app
