// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "assets/files/part_file.h"
#include "poise/result.h"

namespace poise::geometry {

/// A file that appears complete or not at all: it gets its name by commit(). Devices and pipes are written to directly.
/// Invariant: while open, the descriptor is valid. Without a commit the destructor leaves nothing.
class AtomicFile {
 public:
  /// What can be seen of a file before its commit.
  enum class Before : std::uint8_t {
    Hidden,  ///< nothing, where the file system has files without a name (O_TMPFILE), not even of a killed program
    Part,    ///< `.NAME.N.part` in the same folder, which stays when the program is killed
  };

  /// Refused as OutputFailed with the path and the system's reason: a missing folder, no permission, or a path that is
  /// a folder.
  static Result<AtomicFile> open(const std::filesystem::path& path, Before before = Before::Hidden);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  ~AtomicFile();

  /// Takes room for so many bytes now, where the file system can, so that they find it whatever else fills the disk.
  void reserve(std::uint64_t bytes);
  /// Buffers text and writes it in blocks. A failure is stored, and commit() returns it too.
  Status write(std::string_view text);
  /// Hands what is buffered to the system, so that it outlives the program.
  Status flush();
  /// Writes the rest and gives the file its name already; what is written later follows in the named file, and the
  /// destructor leaves it.
  Status publish();
  /// Writes the rest, gives the file its name and closes it. Refused: what could not be written, now or before; then
  /// nothing is left, but for what publish() had named. The file is closed afterwards, whatever the result.
  Status commit();
  /// As commit(), but after a failure the file gets its name all the same and ends with the last write() of which all
  /// reached the system; without any, nothing is left. Refused with the failure.
  Status commit_what_is_whole();
  /// A write or flush was refused.
  [[nodiscard]] bool failing() const { return failure_ != 0; }
  [[nodiscard]] const std::filesystem::path& path() const { return shown_; }

 private:
  AtomicFile() = default;
  void discard();
  Error failed(int reason) const;
  int name_it();

  std::filesystem::path shown_;   ///< the caller's path
  std::filesystem::path target_;  ///< the path with links resolved
  PartFile part_;                 ///< of a regular file without its name
  std::string buffer_;
  std::vector<std::size_t> ends_;  ///< of each write() in the buffer
  std::uint64_t whole_bytes_ = 0;  ///< of the write() calls of which all reached the system
  int descriptor_ = -1;
  int failure_ = 0;
  bool regular_ = false;    ///< no device and no pipe
  bool published_ = false;  ///< it has its name
  bool reserved_ = false;   ///< it may have more room than bytes
};

/// Writes `text` to a file that appears complete or not at all.
Status write_file(const std::filesystem::path& path, std::string_view text);

/// Writes all of `text` to an open descriptor. Returns 0 or the error number; `reached` gets how many bytes the system
/// took.
int write_all(int descriptor, std::string_view text, std::size_t* reached = nullptr);

}  // namespace poise::geometry
