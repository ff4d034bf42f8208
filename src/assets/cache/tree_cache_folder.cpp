// SPDX-License-Identifier: MIT
#include "assets/cache/tree_cache_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <tuple>
#include <vector>

#include "assets/files/atomic_file.h"
#include "assets/files/open_file.h"
#include "assets/files/part_file.h"

namespace poise::geometry {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".poisetree";

/// Creates a folder and its parents with access for this user alone, as the XDG base directory specification requires.
bool make_folder(const fs::path& folder) {
  std::error_code error;
  if (folder.empty() || fs::is_directory(folder, error)) return true;
  if (folder.has_parent_path() && folder.parent_path() != folder && !make_folder(folder.parent_path())) return false;
  return ::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST;
}

struct Entry {
  fs::file_time_type used;
  fs::path file;
  std::uintmax_t bytes = 0;
};

/// Whether a name is what an entry has before it is complete.
bool is_part(const std::string& name) { return PartFile::is_part(name) && name.find(kEnding) != std::string::npos; }

}  // namespace

EntryRead read_entry(const fs::path& file, std::uint64_t most_bytes, std::string& bytes) {
  const Result<OpenFile> open = OpenFile::open(file);
  if (!open) {
    std::error_code failure;
    return fs::exists(file, failure) || failure ? EntryRead::Unusable : EntryRead::Missing;
  }
  if (open.value().bytes() > most_bytes) return EntryRead::Unusable;
  bytes.resize(open.value().bytes());
  return open.value().read(0, bytes) ? EntryRead::Found : EntryRead::Unusable;
}

void touch_entry(const fs::path& file) { static_cast<void>(::utimensat(AT_FDCWD, file.c_str(), nullptr, 0)); }

bool write_entry(const fs::path& file, std::string_view bytes) {
  if (!make_folder(file.parent_path())) return false;
  std::error_code error;
  // Never write through a link or into a device in the entry's place: these are removed. A folder is not removed and
  // makes the call fail.
  const fs::file_status status = fs::symlink_status(file, error);
  if (fs::exists(status) && !fs::is_regular_file(status) && ::unlink(file.c_str()) != 0) return false;
  return write_file(file, bytes).ok();
}

std::size_t keep_limit(const fs::path& kept, std::uint64_t limit_bytes) {
  std::error_code error;
  std::vector<Entry> entries;
  std::uintmax_t total = 0;
  fs::directory_iterator points(kept.parent_path(), error);
  for (; !error && points != fs::directory_iterator(); points.increment(error)) {
    const std::string name = points->path().filename().string();
    if (is_part(name)) PartFile::remove_one_if_stale(points->path());
    if (is_part(name) || !name.ends_with(kEnding)) continue;
    // Another process may have removed it meanwhile; then it is not counted.
    std::error_code gone;
    if (!points->is_regular_file(gone) || points->is_symlink(gone)) continue;
    Entry entry{points->last_write_time(gone), points->path(), 0};
    if (!gone) entry.bytes = points->file_size(gone);
    if (gone) continue;
    total += entry.bytes;
    if (points->path().filename() != kept.filename()) entries.push_back(std::move(entry));
  }
  std::ranges::sort(entries, {}, [](const Entry& entry) { return std::tie(entry.used, entry.file); });
  std::size_t removed = 0;
  for (const Entry& entry : entries) {
    if (total <= limit_bytes) break;
    std::error_code failed;
    if (fs::remove(entry.file, failed)) ++removed;
    if (!failed) total -= entry.bytes;
  }
  return removed;
}

}  // namespace poise::geometry
