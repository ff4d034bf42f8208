// SPDX-License-Identifier: MIT
#include "app/study/study_command.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "app/process/exit_codes.h"
#include "app/process/program_beside.h"
#include "app/process/refusal.h"

namespace poise::app {

void add_study_command(CLI::App& app) {
  app.add_subcommand("study", "Make the figures of the docs (by the program poise-study)");
}

int start_study(int argc, char** argv) {
  const Result<std::filesystem::path> program = program_beside("poise-study");
  if (!program) return refuse("study", program.error());
  std::vector<char*> words(argv, argv + argc);
  words.erase(words.begin() + 1);
  words.push_back(nullptr);
  ::execv(program.value().c_str(), words.data());
  if (errno != ENOENT) return refuse("study", kExitBadInput, program.value().string() + ": " + std::strerror(errno));
  return refuse("study", kExitBadUsage,
                "the studies are a program of their own, " + program.value().string() +
                    ", which is not there; cmake -DPOISE_STUDIES=ON and the target poise_study build it");
}

}  // namespace poise::app
