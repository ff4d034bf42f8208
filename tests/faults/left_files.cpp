// SPDX-License-Identifier: MIT
#include "faults/left_files.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/capture_reader.h"
#include "record/record_file.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

namespace fs = std::filesystem;

/// A table: rows below the head. `cut` is set if the last row has no end or not all cells.
struct Table {
  std::vector<std::string> rows;
  bool cut = false;
  bool sound = false;  ///< all rows but the last have as many cells as the head
};
Table read_table(const fs::path& file) {
  const std::string text = contents(file);
  Table table;
  std::vector<std::string> all = lines(text);
  if (all.empty()) return table;
  const auto columns = std::count(all[0].begin(), all[0].end(), ',');
  const auto full = [columns](const std::string& row) { return std::count(row.begin(), row.end(), ',') == columns; };
  table.cut = text.back() != '\n' || !full(all.back());
  table.rows.assign(all.begin() + 1, all.end());
  if (table.cut && !table.rows.empty()) table.rows.pop_back();
  table.sound = std::all_of(table.rows.begin(), table.rows.end(), full);
  return table;
}

std::uint64_t frames_of_states(const Table& table) {
  if (table.rows.empty()) return 0;
  return std::stoull(table.rows.back().substr(0, table.rows.back().find(','))) + 1;
}

void read_json(const fs::path& file, LeftFiles& left) {
  const nlohmann::json json = nlohmann::json::parse(contents(file), nullptr, false);
  left.json = json.is_object() && json.contains("frames") && json.contains("state_hash");
  if (left.json) left.json_frames = json.at("frames").get<std::uint64_t>();
  if (!left.json) left.problems.push_back(file.string() + ": not whole");
}

std::optional<std::uint64_t> read_record(const fs::path& file, LeftFiles& left, bool& whole) {
  Result<io::RecordReader> reader = io::RecordReader::open(file);
  if (!reader) {
    left.problems.push_back(reader.error().message);
    return {};
  }
  io::RecordedFrame frame;
  std::uint64_t frames = 0;
  io::RecordReader::Next next = reader.value().next(frame);
  for (; next == io::RecordReader::Next::Frame; next = reader.value().next(frame)) ++frames;
  whole = next == io::RecordReader::Next::End;
  return frames;
}

void read_capture(const fs::path& file, LeftFiles& left) {
  Result<capture::CaptureReader> reader = capture::CaptureReader::open(file);
  if (!reader) {
    left.problems.push_back(reader.error().message);
    return;
  }
  std::uint64_t frames = 0;
  const Status read = reader.value().read_frames(0, UINT64_MAX, [&](const capture::PackedFrame&) {
    ++frames;
    return true;
  });
  // A capture that ends before its first block has no frames to read.
  if (!read && reader.value().frames() > 0) left.problems.push_back(read.error().message);
  left.capture = frames;
  left.capture_whole = reader.value().end().has_value() && !reader.value().damage();
}

void read_part(const fs::path& file, LeftFiles& left) {
  const std::string name = file.filename().string();
  left.parts.push_back(name);
  const std::string text = contents(file);
  if (name.starts_with(".run.poise.")) {
    // Until its header and scene are written it is empty.
    bool whole = false;
    if (!text.empty()) left.record_part = read_record(file, left, whole);
  } else if (name.starts_with(".states.csv.")) {
    const Table table = read_table(file);
    if (!table.sound && !text.empty()) left.problems.push_back(name + ": not a table up to its last row");
    left.states_part = frames_of_states(table);
  }
}

}  // namespace

std::vector<std::string> all_outputs(const std::string& folder) {
  std::vector<std::string> options;
  for (const auto& [option, name] : {std::pair{"--json", "run.json"},
                                     {"--frames-csv", "frames.csv"},
                                     {"--states", "states.csv"},
                                     {"--record", "run.poise"},
                                     {"--capture", "run.capture"},
                                     {"--trace", "trace.json"},
                                     {"--picture", "end.png"}}) {
    options.emplace_back(option);
    options.push_back(folder + "/" + name);
  }
  return options;
}

LeftFiles read_left_files(const std::string& folder) {
  LeftFiles left;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(".part")) {
      read_part(entry.path(), left);
    } else if (name == "run.json") {
      read_json(entry.path(), left);
    } else if (name == "run.poise") {
      left.record = read_record(entry.path(), left, left.record_whole);
    } else if (name == "run.capture") {
      read_capture(entry.path(), left);
    } else if (name == "frames.csv" || name == "states.csv" || name == "states.bodies.csv") {
      const Table table = read_table(entry.path());
      if (!table.sound || table.cut) left.problems.push_back(name + ": not whole");
      if (name == "frames.csv") left.frames_csv = table.rows.size();
      if (name == "states.csv") left.states = frames_of_states(table);
    } else if (name == "trace.json") {
      if (!nlohmann::json::accept(contents(entry.path()))) left.problems.push_back(name + ": not whole");
    } else if (name == "end.png") {
      // A PNG ends with the chunk IEND and its checksum.
      const std::string bytes = contents(entry.path());
      if (!bytes.starts_with("\x89PNG") || bytes.find("IEND", bytes.size() - 8) == std::string::npos)
        left.problems.push_back(name + ": not whole");
    }
  }
  return left;
}

}  // namespace poise::testing
