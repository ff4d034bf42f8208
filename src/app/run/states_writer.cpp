// SPDX-License-Identifier: MIT
#include "app/run/states_writer.h"

#include <chrono>
#include <utility>

#include "app/process/refusal.h"

namespace poise::app {

Result<StatesWriter> StatesWriter::open(const std::string& path, StatesFile::WrittenBy by) {
  StatesWriter writer;
  if (path.empty()) return writer;
  Result<StatesFile> file = StatesFile::open(path, by);
  if (!file) return file.error();
  Result<BodyTable> bodies = BodyTable::open(path);
  if (!bodies) return bodies.error();
  writer.file_ = std::move(file).value();
  writer.bodies_ = std::move(bodies).value();
  return writer;
}

Status StatesWriter::add(const Scene& scene, const SceneRun& run, std::uint64_t frame, double time_s,
                         std::span<const io::NumberedState> states) {
  const Status listed = bodies_.add(scene, run);
  return listed ? file_->add(frame, time_s, states, std::chrono::steady_clock::now()) : listed;
}

Status StatesWriter::finish() {
  if (!file_) return Done{};
  Status written = bodies_.finish();
  add_failure(file_->finish(), written);
  return written;
}

}  // namespace poise::app
