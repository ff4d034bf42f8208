// SPDX-License-Identifier: MIT
#include "app/run/states_file.h"

#include <optional>
#include <utility>
#include <vector>

#include "parallel/background_queue.h"
#include "scene/result_file.h"
#include "scene/run/run_tables.h"

namespace poise::app {
namespace {

/// What a killed run loses at most of its states. Chosen.
constexpr std::chrono::milliseconds kFlushEvery{250};

}  // namespace

struct StatesFile::Impl {
  struct Frame {
    std::uint64_t number = 0;
    double time_s = 0;
    std::vector<io::NumberedState> states;
    std::chrono::steady_clock::time_point now;
  };

  explicit Impl(io::AtomicFile opened) : file(std::move(opened)) {}

  Status write(std::uint64_t frame, double time_s, std::span<const io::NumberedState> states,
               std::chrono::steady_clock::time_point now) {
    text.clear();
    if (frame == 0) text = io::states_header();
    io::append_states(frame, time_s, states, text);
    const Status written = file.write(text);
    if (!written || (flushed && now - *flushed < kFlushEvery)) return written;
    flushed = now;
    return file.flush();
  }

  // Of the queue's thread until finish(), if there is one.
  io::AtomicFile file;
  std::string text;
  std::optional<std::chrono::steady_clock::time_point> flushed;
  std::optional<parallel::BackgroundQueue<Frame>> queue;  // the last member: its thread uses the others
};

StatesFile::StatesFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StatesFile::StatesFile(StatesFile&&) noexcept = default;
StatesFile& StatesFile::operator=(StatesFile&&) noexcept = default;
StatesFile::~StatesFile() = default;

Result<StatesFile> StatesFile::open(const std::string& path, WrittenBy by) {
  Result<io::AtomicFile> file = io::AtomicFile::open(path, io::AtomicFile::Before::Part);
  if (!file) return file.error();
  auto impl = std::make_unique<Impl>(std::move(file).value());
  if (by == WrittenBy::OwnThread) {
    impl->queue.emplace(kFramesWaiting, [to = impl.get()](Impl::Frame& frame) {
      return to->write(frame.number, frame.time_s, frame.states, frame.now);
    });
  }
  return StatesFile(std::move(impl));
}

Status StatesFile::add(std::uint64_t frame, double time_s, std::span<const io::NumberedState> states,
                       std::chrono::steady_clock::time_point now) {
  if (!impl_->queue) return impl_->write(frame, time_s, states, now);
  Status failed = impl_->queue->failure();
  if (!failed) return failed;
  Impl::Frame next = impl_->queue->fresh();
  next.number = frame;
  next.time_s = time_s;
  next.states.assign(states.begin(), states.end());
  next.now = now;
  impl_->queue->push(std::move(next));
  return Done{};
}

Status StatesFile::finish() {
  if (impl_->queue) impl_->queue->close();
  return impl_->file.commit_what_is_whole();
}

}  // namespace poise::app
