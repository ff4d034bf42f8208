// SPDX-License-Identifier: MIT
#include "capture/capture_writer.h"

#include <utility>

#include "assets/files/atomic_file.h"
#include "capture/block_writer.h"
#include "parallel/background_queue.h"

namespace poise::capture {

struct CaptureWriter::Impl {
  Impl(geometry::AtomicFile opened, std::size_t frames_waiting)
      : file(std::move(opened)), queue(frames_waiting, [this](SeenFrame& frame) { return work(frame); }) {}
  ~Impl() { queue.close(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void write(const Status& made) {
    if (sound && !made)
      sound = Error{made.error().kind, file.path().string() + ": cannot be written: " + made.error().message};
    if (!sound || out.empty()) return;
    // Each block reaches the system at once, so that it outlives the program.
    sound = file.write(out);
    if (sound) sound = file.flush();
    if (sound) written += out.size();
    out.clear();
  }
  // On the queue's thread.
  Status work(SeenFrame& frame) {
    if (sound) write(blocks.add(frame, out));
    frame.facts = {};
    frame.new_bodies.clear();
    frame.bodies.clear();
    frame.contacts.clear();
    frame.pairs.clear();
    return sound;
  }

  std::uint64_t frames = 0;  // that were handed over
  std::uint64_t left_out = 0;
  std::uint32_t left_out_now = 0;  // since the last frame that was handed over
  // Of the queue's thread between begin() and finish().
  geometry::AtomicFile file;
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
  Result<geometry::AtomicFile> file = geometry::AtomicFile::open(path);
  if (!file) return file.error();
  return CaptureWriter(std::make_unique<Impl>(std::move(file).value(), frames_waiting));
}

Status CaptureWriter::begin(const CaptureHeader& header) {
  impl_->write(impl_->blocks.begin(header, impl_->out));
  // Only now, so that a file that was there goes when what takes its place can be opened.
  if (impl_->sound) impl_->sound = impl_->file.publish();
  return impl_->sound;
}

Status CaptureWriter::failure() const { return impl_->queue.failure(); }

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
  // What is there up to a failure is a capture that ends early.
  const Status closed = impl_->file.commit_what_is_whole();
  if (!closed) impl_->sound = closed;
  return impl_->sound;
}

std::uint64_t CaptureWriter::bytes() const { return impl_->written; }

}  // namespace poise::capture
