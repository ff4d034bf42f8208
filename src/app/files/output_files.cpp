// SPDX-License-Identifier: MIT
#include "app/files/output_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "app/process/refusal.h"

namespace poise::app {
namespace {

bool is_file(const std::string& path) { return !path.empty() && path != "-"; }

/// Something that is there and no regular file, nor a folder.
bool is_special(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
         !std::filesystem::is_directory(status);
}

/// Both are there, and are the same.
bool same_file(const std::string& a, const std::string& b) {
  std::error_code failure;
  return is_file(a) && is_file(b) && std::filesystem::equivalent(a, b, failure) && !failure && !is_special(a);
}

/// Will be the same once they are written.
bool same_output(const std::string& a, const std::string& b) {
  const bool same_name = std::filesystem::path(a).lexically_normal() == std::filesystem::path(b).lexically_normal();
  return same_file(a, b) || (same_name && is_file(a) && !is_special(a));
}

}  // namespace

Status check_outputs(std::initializer_list<NamedFile> outputs, std::initializer_list<NamedFile> inputs) {
  for (const NamedFile* a = outputs.begin(); a != outputs.end(); ++a) {
    for (const NamedFile* b = outputs.begin(); b != a; ++b) {
      if (same_output(a->path, b->path)) {
        return bad_input(fmt::format("{} is named for two outputs: {} and {}", a->path, b->option, a->option));
      }
    }
    for (const NamedFile& input : inputs) {
      if (same_file(a->path, input.path)) {
        return bad_input(
            fmt::format("{} {}: would overwrite the file that is read as {}", a->option, a->path, input.option));
      }
    }
  }
  return Done{};
}

std::string lower_case_ending(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

Status check_picture(const std::string& path, const char* option) {
  const std::string ending = lower_case_ending(path);
  if (ending.empty() || ending == ".png") return Done{};
  return bad_input(fmt::format("{} {}: a PNG is written, so the ending must be .png", option, path));
}

Status can_write(std::initializer_list<std::string> paths) {
  Status all = Done{};
  for (const std::string& path : paths) {
    if (!is_file(path) || is_special(path)) continue;
    const Result<io::AtomicFile> tried = io::AtomicFile::open(path);
    if (!tried) add_failure(tried.error(), all);
  }
  return all;
}

std::optional<io::AtomicFile> open_file(const std::string& path, Status& all) {
  if (!is_file(path)) return {};
  Result<io::AtomicFile> opened = io::AtomicFile::open(path);
  if (opened) return std::move(opened).value();
  add_failure(opened.error(), all);
  return {};
}

Status make_folder(const char* option, const std::string& path) {
  std::error_code failure;
  std::filesystem::create_directories(path, failure);
  if (!failure) return Done{};
  return Error{ErrorKind::OutputFailed, fmt::format("{}: {}: cannot be made: {}", option, path, failure.message())};
}

Status write_to(const std::string& path, const std::string& text) {
  if (path.empty()) return Done{};
  return path == "-" ? io::write_stdout(text) : io::write_file(path, text);
}

}  // namespace poise::app
