// SPDX-License-Identifier: MIT
#include "assets/files/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace poise::geometry {
namespace {

constexpr std::size_t kBlockBytes = 1U << 18U;
constexpr int kAttempts = 100;

}  // namespace

int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

Error AtomicFile::failed(int reason) const {
  return {ErrorKind::OutputFailed,
          fmt::format("{}: cannot be written: {}", shown_.string(), std::generic_category().message(reason))};
}

Result<AtomicFile> AtomicFile::open(const std::filesystem::path& path) {
  AtomicFile file;
  file.shown_ = path;
  std::error_code failure;
  file.target_ = path;
  if (std::filesystem::is_symlink(path, failure)) {
    const std::filesystem::path followed = std::filesystem::weakly_canonical(path, failure);
    if (!failure) file.target_ = followed;
  }
  struct stat status {};
  const bool exists = ::stat(file.target_.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) return file.failed(EISDIR);
  if (exists && !S_ISREG(status.st_mode)) {
    file.descriptor_ = ::open(file.target_.c_str(), O_WRONLY | O_CLOEXEC);
    if (file.descriptor_ < 0) return file.failed(errno);
    return file;
  }
  if (file.target_.filename().empty()) return file.failed(path.empty() ? ENOENT : EISDIR);
  if (exists && ::access(file.target_.c_str(), W_OK) != 0) return file.failed(errno);
  // Two programs may write the same file at once, so each needs its own temporary name.
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const std::string name = fmt::format(".{}.{}-{}.part", file.target_.filename().string(), ::getpid(), attempt);
    std::filesystem::path temporary = file.target_.parent_path() / name;
    file.descriptor_ = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file.descriptor_ >= 0) {
      file.temporary_ = std::move(temporary);
      // The mode of a replaced file is preserved if the system permits it.
      if (exists) static_cast<void>(::fchmod(file.descriptor_, status.st_mode & 07777U));
      return file;
    }
    if (errno != EEXIST) break;
  }
  return file.failed(errno);
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : shown_(std::move(other.shown_)),
      target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      buffer_(std::move(other.buffer_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      failure_(other.failure_) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  if (this == &other) return *this;
  discard();
  shown_ = std::move(other.shown_);
  target_ = std::move(other.target_);
  temporary_ = std::exchange(other.temporary_, {});
  buffer_ = std::move(other.buffer_);
  descriptor_ = std::exchange(other.descriptor_, -1);
  failure_ = other.failure_;
  return *this;
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::discard() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
}

Status AtomicFile::flush() {
  if (failure_ == 0 && descriptor_ < 0) failure_ = EBADF;
  if (failure_ == 0) failure_ = write_all(descriptor_, buffer_);
  buffer_.clear();
  if (failure_ != 0) return failed(failure_);
  return Done{};
}

Status AtomicFile::write(std::string_view text) {
  buffer_.append(text);
  return buffer_.size() < kBlockBytes && failure_ == 0 ? Status(Done{}) : flush();
}

Status AtomicFile::commit() {
  const Status flushed = flush();
  if (!flushed) {
    discard();
    return flushed;
  }
  const int closed = ::close(std::exchange(descriptor_, -1));
  if (closed != 0 || (!temporary_.empty() && ::rename(temporary_.c_str(), target_.c_str()) != 0)) {
    const Error error = failed(errno);
    discard();
    return error;
  }
  temporary_.clear();
  return Done{};
}

Status write_file(const std::filesystem::path& path, std::string_view text) {
  Result<AtomicFile> file = AtomicFile::open(path);
  if (!file) return file.error();
  const Status written = file.value().write(text);
  if (!written) return written;
  return file.value().commit();
}

}  // namespace poise::geometry
