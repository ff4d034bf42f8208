// SPDX-License-Identifier: MIT
#include "app/run/body_table.h"

#include <filesystem>
#include <system_error>

#include "scene/run/run_tables.h"

namespace poise::app {

std::string body_table_of(const std::string& states) {
  if (states.empty()) return {};
  const std::filesystem::path path(states);
  std::error_code none;
  // There is nothing beside a pipe or a device.
  if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none)) return {};
  return path.parent_path() / (path.stem().string() + ".bodies" + path.extension().string());
}

Result<BodyTable> BodyTable::open(const std::string& states) {
  BodyTable table;
  const std::string path = body_table_of(states);
  if (path.empty()) return table;
  Result<io::AtomicFile> file = io::AtomicFile::open(path);
  if (!file) return file.error();
  table.file_ = std::move(file).value();
  table.text_ = io::bodies_header();
  return table;
}

Status BodyTable::add(const Scene& scene, const SceneRun& run) {
  if (!file_) return Done{};
  for (const RunBody& body : run.bodies()) {
    if (body.number < next_number_) continue;
    next_number_ = body.number + 1;
    double mass_kg = 0;
    if (body.motion == MotionType::Dynamic) {
      const Result<double> mass = run.world().mass_kg(body.id);
      if (!mass) return mass.error();
      mass_kg = mass.value();
    }
    io::append_body(scene, body, mass_kg, text_);
  }
  return Done{};
}

Status BodyTable::finish() {
  if (!file_) return Done{};
  const Status written = file_->write(text_);
  return written ? file_->commit() : written;
}

}  // namespace poise::app
