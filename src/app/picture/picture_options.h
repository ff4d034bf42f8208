// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "app/picture/frame_picture.h"
#include "poise/result.h"
#include "scene/result_file.h"

namespace poise::app {

/// The options of commands that draw frames.
struct PictureOptions {
  std::string file;        ///< --picture
  std::string frames_dir;  ///< --frames-dir
  std::string camera, size;
  bool plain = false;
  [[nodiscard]] bool any() const { return !file.empty() || !frames_dir.empty(); }
};

/// `of_picture` tells which frame --picture draws.
void add_picture_options(CLI::App& command, PictureOptions& options, const std::string& of_picture);
/// --frames-dir; `frames` tells which frames.
void add_frames_dir(CLI::App& command, PictureOptions& options, const std::string& frames);
/// Refused: options that need a picture without one, values that are wrong, the standard output.
Status check_picture_options(const PictureOptions& options);
/// Options that check_picture_options takes.
io::PictureSettings picture_settings(const PictureOptions& options);

/// The numbered pictures of `--frames-dir`, each under its name when it is complete; without the option nothing.
class FilmFrames {
 public:
  /// Makes the folder. Refused (OutputFailed): where that is not possible.
  static Result<FilmFrames> open(const PictureOptions& options);
  [[nodiscard]] bool on() const { return !folder_.empty(); }
  Status write(std::uint64_t frame, const io::Image& image);
  [[nodiscard]] std::uint64_t written() const { return written_; }

 private:
  std::string folder_;
  std::uint64_t written_ = 0;
};

}  // namespace poise::app
