// SPDX-License-Identifier: MIT
#include "assets/files/part_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace poise::geometry {
namespace {

namespace fs = std::filesystem;

/// Programs that write the same file at once, and files that killed ones left. Chosen.
constexpr int kNames = 100;

fs::path part_name(const fs::path& target, int number) {
  // No longer than what a folder takes, where the name itself is as long as that.
  constexpr std::size_t kMostOfName = 240;
  return target.parent_path() / fmt::format(".{}.{}.part", target.filename().string().substr(0, kMostOfName), number);
}

/// The path by which the system finds a file without a name.
std::string name_of(int descriptor) { return fmt::format("/proc/self/fd/{}", descriptor); }

bool names_it(const fs::path& name, int descriptor) {
  struct stat named {};
  struct stat open {};
  return ::lstat(name.c_str(), &named) == 0 && ::fstat(descriptor, &open) == 0 && named.st_dev == open.st_dev &&
         named.st_ino == open.st_ino;
}

/// Removes a file of this name that no living program holds. Returns whether the name is free.
bool remove_if_stale(const fs::path& name) {
  const int descriptor = ::open(name.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return errno == ENOENT;
  bool removed = false;
  // While the lock is held, nobody else removes the name, so that it cannot be another file's in between.
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && names_it(name, descriptor)) removed = ::unlink(name.c_str()) == 0;
  ::close(descriptor);
  return removed;
}

int link_to(int descriptor, const fs::path& name) {
  const std::string source = name_of(descriptor);
  return ::linkat(AT_FDCWD, source.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0 ? 0 : errno;
}

/// A file without a name in the folder, with its lock; -1 where the file system has none, or it could get no name
/// later.
int open_nameless(const fs::path& target, mode_t mode) {
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const int descriptor = ::open(folder.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, mode);
  if (descriptor < 0) return -1;
  if (::access(name_of(descriptor).c_str(), F_OK) == 0) {
    // Where locks are missing, files that killed programs left stay.
    static_cast<void>(::flock(descriptor, LOCK_EX | LOCK_NB));
    return descriptor;
  }
  ::close(descriptor);
  return -1;
}

}  // namespace

int PartFile::open(const fs::path& target, bool hidden, mode_t mode, int& descriptor) {
  descriptor = open_nameless(target, mode);
  const bool nameless = descriptor >= 0;
  if (nameless && hidden) return 0;
  // A part that can be read may be worth keeping until the run that follows is complete.
  int failure = EEXIST;
  for (const bool replace_stale : {hidden, true}) {
    if (failure == EEXIST)
      failure =
          nameless ? take_name(target, replace_stale, descriptor) : create(target, replace_stale, mode, descriptor);
  }
  if (failure != 0 && nameless) {
    ::close(descriptor);
    descriptor = -1;
  }
  return failure;
}

int PartFile::take_name(const fs::path& target, bool replace_stale, int descriptor) {
  for (int number = 0; number < kNames; ++number) {
    fs::path name = part_name(target, number);
    int failure = link_to(descriptor, name);
    if (failure == EEXIST && replace_stale && remove_if_stale(name)) failure = link_to(descriptor, name);
    if (failure == 0) name_ = std::move(name);
    if (failure != EEXIST) return failure;
  }
  return EEXIST;
}

int PartFile::create(const fs::path& target, bool replace_stale, mode_t mode, int& descriptor) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
  for (int number = 0; number < kNames; ++number) {
    fs::path name = part_name(target, number);
    descriptor = ::open(name.c_str(), kFlags, mode);
    if (descriptor < 0 && errno == EEXIST && replace_stale && remove_if_stale(name))
      descriptor = ::open(name.c_str(), kFlags, mode);
    if (descriptor < 0 && errno != EEXIST) return errno;
    if (descriptor < 0) continue;
    // Before it had its lock it may have been taken for one that was left; then it has no name any more.
    static_cast<void>(::flock(descriptor, LOCK_EX));
    if (names_it(name, descriptor)) {
      name_ = std::move(name);
      return 0;
    }
    ::close(descriptor);
    descriptor = -1;
  }
  return EEXIST;
}

int PartFile::rename_to(const fs::path& target, int descriptor) {
  if (name_.empty()) {
    const int failure = link_to(descriptor, target);
    if (failure != EEXIST) return failure;
    // A link replaces nothing, so it takes a name of which one can be renamed.
    const int taken = take_name(target, true, descriptor);
    if (taken != 0) return taken;
  }
  if (::rename(name_.c_str(), target.c_str()) != 0) return errno;
  name_.clear();
  return 0;
}

void PartFile::remove() {
  if (!name_.empty()) ::unlink(name_.c_str());
  name_.clear();
}

bool PartFile::is_part(std::string_view name) { return name.starts_with('.') && name.ends_with(".part"); }

void PartFile::remove_one_if_stale(const fs::path& part) { static_cast<void>(remove_if_stale(part)); }

void PartFile::remove_stale(const fs::path& target) {
  for (int number = 0; number < kNames; ++number) static_cast<void>(remove_if_stale(part_name(target, number)));
}

}  // namespace poise::geometry
