// SPDX-License-Identifier: MIT
#include "assets/files/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace poise::geometry {
namespace {

constexpr std::size_t kBlockBytes = 1U << 18U;
constexpr mode_t kUsualRights = 0666;

// Room that cannot be given back stays taken: nothing is lost by that.
void cut(int descriptor, off_t bytes) { [[maybe_unused]] const int result = ::ftruncate(descriptor, bytes); }

// Follows links to what is to be written, also where nothing is there yet. 0, or why they lead nowhere. What is no
// file, as a pipe that a link of the system's names, is opened by that link.
int follow_links(std::filesystem::path& path) {
  constexpr int kMostLinks = 40;  // as Linux has it
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) return 0;
  std::error_code failure;
  for (int links = 0; std::filesystem::is_symlink(path, failure); ++links) {
    if (links == kMostLinks) return ELOOP;
    const std::filesystem::path next = std::filesystem::read_symlink(path, failure);
    if (failure) return failure.value();
    path = next.is_absolute() ? next : path.parent_path() / next;
  }
  return 0;
}

}  // namespace

int write_all(int descriptor, std::string_view text, std::size_t* reached) {
  std::size_t done = 0;
  int failure = 0;
  while (done < text.size() && failure == 0) {
    const ssize_t written = ::write(descriptor, text.data() + done, text.size() - done);
    if (written >= 0) {
      done += static_cast<std::size_t>(written);
    } else if (errno != EINTR) {
      failure = errno;
    }
  }
  if (reached != nullptr) *reached = done;
  return failure;
}

Error AtomicFile::failed(int reason) const {
  return {ErrorKind::OutputFailed,
          fmt::format("{}: cannot be written: {}", shown_.string(), std::generic_category().message(reason))};
}

Result<AtomicFile> AtomicFile::open(const std::filesystem::path& path, Before before) {
  AtomicFile file;
  file.shown_ = path;
  file.target_ = path;
  const int lost = follow_links(file.target_);
  if (lost != 0) return file.failed(lost);
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
  const int opened = file.part_.open(file.target_, before == Before::Hidden, kUsualRights, file.descriptor_);
  if (opened != 0) return file.failed(opened);
  file.regular_ = true;
  // The mode of a replaced file is preserved if the system permits it.
  if (exists) static_cast<void>(::fchmod(file.descriptor_, status.st_mode & 07777U));
  return file;
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : shown_(std::move(other.shown_)),
      target_(std::move(other.target_)),
      part_(std::exchange(other.part_, {})),
      buffer_(std::move(other.buffer_)),
      ends_(std::move(other.ends_)),
      whole_bytes_(other.whole_bytes_),
      descriptor_(std::exchange(other.descriptor_, -1)),
      failure_(other.failure_),
      regular_(other.regular_),
      published_(other.published_),
      reserved_(other.reserved_) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  if (this == &other) return *this;
  discard();
  shown_ = std::move(other.shown_);
  target_ = std::move(other.target_);
  part_ = std::exchange(other.part_, {});
  buffer_ = std::move(other.buffer_);
  ends_ = std::move(other.ends_);
  whole_bytes_ = other.whole_bytes_;
  descriptor_ = std::exchange(other.descriptor_, -1);
  failure_ = other.failure_;
  regular_ = other.regular_;
  published_ = other.published_;
  reserved_ = other.reserved_;
  return *this;
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::discard() {
  part_.remove();
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

Status AtomicFile::flush() {
  if (failure_ == 0 && descriptor_ < 0) failure_ = EBADF;
  if (failure_ == 0) {
    std::size_t reached = 0;
    failure_ = write_all(descriptor_, buffer_, &reached);
    const auto past = std::ranges::upper_bound(ends_, reached);
    if (past != ends_.begin()) whole_bytes_ += *(past - 1);
    // What reached the system in part is of no use, and takes room that others may need.
    if (failure_ != 0 && regular_) cut(descriptor_, static_cast<off_t>(whole_bytes_));
  }
  buffer_.clear();
  ends_.clear();
  if (failure_ != 0) return failed(failure_);
  return Done{};
}

void AtomicFile::reserve(std::uint64_t bytes) {
  if (!regular_) return;
  reserved_ = ::fallocate(descriptor_, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)) == 0;
}

Status AtomicFile::write(std::string_view text) {
  if (failure_ == 0) {
    buffer_.append(text);
    ends_.push_back(buffer_.size());
  }
  return buffer_.size() < kBlockBytes && failure_ == 0 ? Status(Done{}) : flush();
}

int AtomicFile::name_it() {
  if (!regular_ || published_) return 0;
  // What was reserved and is not needed.
  struct stat status {};
  if (reserved_ && ::fstat(descriptor_, &status) == 0) cut(descriptor_, status.st_size);
  // Some file systems tell only at a close what they could not write. The lock stays with the other descriptor.
  const int second = ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
  if (second >= 0 && ::close(second) != 0) return errno;
  const int named = part_.rename_to(target_, descriptor_);
  if (named != 0) return named;
  published_ = true;
  PartFile::remove_stale(target_);
  return 0;
}

Status AtomicFile::publish() {
  const Status flushed = flush();
  if (!flushed) return flushed;
  failure_ = name_it();
  if (failure_ != 0) return failed(failure_);
  return Done{};
}

Status AtomicFile::commit() {
  const Status published = publish();
  if (!published) {
    discard();
    return published;
  }
  if (::close(std::exchange(descriptor_, -1)) != 0) return failed(errno);
  return Done{};
}

Status AtomicFile::commit_what_is_whole() {
  const Status flushed = flush();
  if (flushed) return commit();
  const bool kept = regular_ && descriptor_ >= 0 && whole_bytes_ > 0 && name_it() == 0;
  discard();
  if (!kept) return flushed;
  return Error{flushed.error().kind, flushed.error().message + "; what was written before is there"};
}

Status write_file(const std::filesystem::path& path, std::string_view text) {
  Result<AtomicFile> file = AtomicFile::open(path);
  if (!file) return file.error();
  const Status written = file.value().write(text);
  if (!written) return written;
  return file.value().commit();
}

}  // namespace poise::geometry
