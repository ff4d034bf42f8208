// SPDX-License-Identifier: MIT
#include "assets/files/open_file.h"

#include <system_error>

namespace poise::geometry {

Result<OpenFile> open_file(const std::filesystem::path& path) {
  std::error_code failure;
  if (!std::filesystem::is_regular_file(path, failure)) return bad_input(path.string() + ": no such file");
  OpenFile file;
  file.stream.open(path, std::ios::binary);
  file.bytes = std::filesystem::file_size(path, failure);
  if (!file.stream || failure) return bad_input(path.string() + ": cannot be opened for reading");
  return file;
}

}  // namespace poise::geometry
