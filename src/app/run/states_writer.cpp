// SPDX-License-Identifier: MIT
#include "app/run/states_writer.h"

#include "app/refusal.h"
#include "scene/run/run_tables.h"

namespace poise::app {
namespace {

/// What a killed run loses at most of its states. Chosen.
constexpr std::chrono::milliseconds kFlushStatesEvery{250};

}  // namespace

Result<StatesWriter> StatesWriter::open(const std::string& path) {
  StatesWriter writer;
  if (path.empty()) return writer;
  Result<io::AtomicFile> file = io::AtomicFile::open(path, io::AtomicFile::Before::Part);
  if (!file) return file.error();
  Result<BodyTable> bodies = BodyTable::open(path);
  if (!bodies) return bodies.error();
  writer.file_ = std::move(file).value();
  writer.bodies_ = std::move(bodies).value();
  return writer;
}

Status StatesWriter::add(const Scene& scene, const SceneRun& run, std::uint64_t frame, double time_s,
                         std::span<const io::NumberedState> states, bool wait) {
  const Status listed = bodies_.add(scene, run);
  if (!listed) return listed;
  if (!wait) return write(frame, time_s, states);
  waiting_.push_back({frame, time_s, {states.begin(), states.end()}});
  return Done{};
}

Status StatesWriter::write(std::uint64_t frame, double time_s, std::span<const io::NumberedState> states) {
  text_.clear();
  if (frame == 0) text_ = io::states_header();
  io::append_states(frame, time_s, states, text_);
  const Status written = file_->write(text_);
  const auto now = std::chrono::steady_clock::now();
  if (!written || now - flushed_ < kFlushStatesEvery) return written;
  flushed_ = now;
  return file_->flush();
}

Status StatesWriter::finish() {
  if (!file_) return Done{};
  for (const Waiting& waiting : waiting_) {
    // The file keeps its first failure, and tells it below.
    if (!write(waiting.frame, waiting.time_s, waiting.states)) break;
  }
  Status written = bodies_.finish();
  add_failure(file_->commit_what_is_whole(), written);
  return written;
}

}  // namespace poise::app
