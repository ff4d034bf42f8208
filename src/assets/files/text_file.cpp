// SPDX-License-Identifier: MIT
#include "assets/files/text_file.h"

#include <fmt/format.h>

#include "assets/files/open_file.h"

namespace poise::geometry {

Result<std::string> read_bytes(const std::filesystem::path& file, std::uint64_t limit_bytes) {
  const Result<OpenFile> open = OpenFile::open(file);
  if (!open) return bad_input("cannot be read: " + open.error().message);
  const std::uint64_t size = open.value().bytes();
  if (size > limit_bytes)
    return bad_input(fmt::format("cannot be read: {} bytes, at most {} are accepted", size, limit_bytes));
  std::string bytes(size, '\0');
  if (!open.value().read(0, bytes))
    return bad_input("cannot be read: it became shorter, or the system reports an error");
  return bytes;
}

Result<std::string> read_text_file(const std::filesystem::path& file, std::uint64_t limit_bytes) {
  Result<std::string> bytes = read_bytes(file, limit_bytes);
  if (!bytes) return bad_input(fmt::format("{}: {}", file.string(), bytes.error().message));
  return bytes;
}

}  // namespace poise::geometry
