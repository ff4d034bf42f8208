// SPDX-License-Identifier: MIT
#include "assets/files/open_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace poise::geometry {

Result<OpenFile> OpenFile::open(const std::filesystem::path& path) {
  // Without O_NONBLOCK a pipe would be waited for before it can be seen that it is one.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor < 0) {
    if (errno == ENOENT || errno == ENOTDIR) return bad_input("no such file");
    if (errno == EACCES) return bad_input("no permission");
    return bad_input(std::generic_category().message(errno));
  }
  struct stat status {};
  const bool known = ::fstat(descriptor, &status) == 0 && status.st_size >= 0;
  OpenFile file(descriptor, known ? static_cast<std::uint64_t>(status.st_size) : 0);
  if (!known || !S_ISREG(status.st_mode)) return bad_input("not a file: a folder, a pipe or a device");
  return file;
}

OpenFile::OpenFile(OpenFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), bytes_(other.bytes_) {}

OpenFile& OpenFile::operator=(OpenFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

OpenFile::~OpenFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool OpenFile::read(std::uint64_t at, std::span<char> target) const {
  while (!target.empty()) {
    const ssize_t got = ::pread(descriptor_, target.data(), target.size(), static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += static_cast<std::uint64_t>(got);
    target = target.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

}  // namespace poise::geometry
