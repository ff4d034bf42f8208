// SPDX-License-Identifier: MIT
#include "assets/files/text_file.h"

#include <fstream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>

namespace poise::geometry {

Result<std::string> read_text_file(const std::filesystem::path& file, std::uint64_t limit_bytes) {
  std::error_code error;
  const auto refuse = [&](const std::string& why) {
    return bad_input(fmt::format("{}: cannot be read: {}", file.string(), why));
  };
  if (!std::filesystem::is_regular_file(file, error)) return refuse("no such file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (!error && size > limit_bytes) return refuse(fmt::format("{} bytes, at most {} are accepted", size, limit_bytes));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return refuse("no permission");
  std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (stream.bad()) return refuse("the system reports an error");
  return text;
}

}  // namespace poise::geometry
