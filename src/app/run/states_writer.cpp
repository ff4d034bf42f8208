// SPDX-License-Identifier: MIT
#include "app/run/states_writer.h"

#include "scene/run/run_tables.h"

namespace poise::app {

Result<StatesWriter> StatesWriter::open(const std::string& path) {
  StatesWriter writer;
  if (path.empty()) return writer;
  Result<io::AtomicFile> file = io::AtomicFile::open(path);
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
  return file_->write(text_);
}

Status StatesWriter::finish() {
  if (!file_) return Done{};
  for (const Waiting& waiting : waiting_) {
    const Status written = write(waiting.frame, waiting.time_s, waiting.states);
    if (!written) return written;
  }
  const Status written = bodies_.finish();
  return written ? file_->commit() : written;
}

}  // namespace poise::app
