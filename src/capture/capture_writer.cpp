// SPDX-License-Identifier: MIT
#include "capture/capture_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "assets/files/atomic_file.h"
#include "capture/block_writer.h"
#include "parallel/background_queue.h"

namespace poise::capture {

struct CaptureWriter::Impl {
  Impl(std::filesystem::path file_path, int file, bool is_new, std::size_t frames_waiting)
      : path(std::move(file_path)),
        descriptor(file),
        empty_and_new(is_new),
        queue(frames_waiting, [this](SeenFrame& frame) { work(frame); }) {}
  ~Impl() {
    queue.close();
    close();
    std::error_code ignored;
    if (empty_and_new) std::filesystem::remove(path, ignored);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void close() {
    if (descriptor >= 0 && ::close(std::exchange(descriptor, -1)) != 0 && sound) sound = failed(errno);
  }
  [[nodiscard]] Error failed(int reason) const {
    return {ErrorKind::OutputFailed,
            fmt::format("{}: cannot be written: {}", path.string(), std::generic_category().message(reason))};
  }
  void write(const Status& made) {
    if (sound && !made)
      sound = Error{made.error().kind, path.string() + ": cannot be written: " + made.error().message};
    if (!sound || out.empty()) return;
    const int reason = geometry::write_all(descriptor, out);
    if (reason != 0) sound = failed(reason);
    written += out.size();
    out.clear();
  }
  // On the queue's thread.
  void work(SeenFrame& frame) {
    if (sound) write(blocks.add(frame, out));
    frame.facts = {};
    frame.new_bodies.clear();
    frame.bodies.clear();
    frame.contacts.clear();
    frame.pairs.clear();
  }

  const std::filesystem::path path;
  int descriptor = -1;
  bool empty_and_new = false;  // made by open(), and nothing was written yet
  std::uint64_t frames = 0;    // that were handed over
  std::uint64_t left_out = 0;
  std::uint32_t left_out_now = 0;  // since the last frame that was handed over
  // Of the queue's thread between begin() and finish().
  BlockWriter blocks;
  std::string out;
  std::uint64_t written = 0;
  Status sound = Done{};
  parallel::BackgroundQueue<SeenFrame> queue;  // the last member: its thread uses the others
};

CaptureWriter::CaptureWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CaptureWriter::CaptureWriter(CaptureWriter&&) noexcept = default;
CaptureWriter& CaptureWriter::operator=(CaptureWriter&&) noexcept = default;
CaptureWriter::~CaptureWriter() = default;

Result<CaptureWriter> CaptureWriter::open(const std::filesystem::path& path, std::size_t frames_waiting) {
  constexpr mode_t kUsualRights = 0666;
  int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kUsualRights);
  const bool is_new = descriptor >= 0;
  if (!is_new) descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, kUsualRights);
  if (descriptor < 0) {
    return Error{ErrorKind::OutputFailed,
                 fmt::format("{}: cannot be written: {}", path.string(), std::generic_category().message(errno))};
  }
  return CaptureWriter(std::make_unique<Impl>(path, descriptor, is_new, frames_waiting));
}

Status CaptureWriter::begin(const CaptureHeader& header) {
  // A pipe has no length to cut.
  if (::ftruncate(impl_->descriptor, 0) != 0 && errno != EINVAL) return impl_->failed(errno);
  impl_->write(impl_->blocks.begin(header, impl_->out));
  if (impl_->written > 0) impl_->empty_and_new = false;
  return impl_->sound;
}

bool CaptureWriter::has_room() const { return impl_->queue.has_room(); }

SeenFrame CaptureWriter::fresh() { return impl_->queue.fresh(); }

void CaptureWriter::add(SeenFrame frame) {
  frame.facts.left_out = std::exchange(impl_->left_out_now, 0);
  ++impl_->frames;
  impl_->queue.push(std::move(frame));
}

void CaptureWriter::leave_out() {
  ++impl_->left_out;
  ++impl_->left_out_now;
}

std::uint64_t CaptureWriter::left_out() const { return impl_->left_out; }

std::uint64_t CaptureWriter::frames() const { return impl_->frames; }

Status CaptureWriter::finish(bool stopped) {
  impl_->queue.close();
  if (impl_->sound) impl_->write(impl_->blocks.finish(impl_->left_out, stopped, impl_->out));
  impl_->close();
  return impl_->sound;
}

std::uint64_t CaptureWriter::bytes() const { return impl_->written; }

}  // namespace poise::capture
