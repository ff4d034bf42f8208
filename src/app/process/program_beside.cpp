// SPDX-License-Identifier: MIT
#include "app/process/program_beside.h"

#include <system_error>

namespace poise::app {

Result<std::filesystem::path> program_beside(std::string_view name) {
  std::error_code failure;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failure);
  if (failure) return bad_input("/proc/self/exe: " + failure.message());
  return program.parent_path() / name;
}

}  // namespace poise::app
