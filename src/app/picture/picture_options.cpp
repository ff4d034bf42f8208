// SPDX-License-Identifier: MIT
#include "app/picture/picture_options.h"

#include <fmt/format.h>

#include <filesystem>

#include "app/files/output_files.h"
#include "app/options/option_values.h"
#include "app/picture/picture.h"

namespace poise::app {

void add_picture_options(CLI::App& command, PictureOptions& options, const std::string& of_picture) {
  add_path(command, "--picture", options.file,
           "Draw the bodies as a PNG, coloured by the level that they reached: " + of_picture);
  add_text(command, "--camera", options.camera,
           "Instead of the scene's camera for pictures: where it stands, where it looks, its vertical angle "
           "(default 50)")
      ->type_name("x,y,z:tx,ty,tz[:DEG]");
  add_text(command, "--picture-size", options.size, "Of pictures, in pixels (default: the scene camera's resolution)")
      ->type_name("WxH");
  command.add_flag("--picture-plain", options.plain, "Pictures without words, legend and the ring of the gaze");
}

void add_frames_dir(CLI::App& command, PictureOptions& options, const std::string& frames) {
  add_path(command, "--frames-dir", options.frames_dir,
           "Draw frames into this folder as frame-000123.png, for films: " + frames);
}

Status check_picture_options(const PictureOptions& options) {
  if (options.file == "-" || options.frames_dir == "-") return bad_input("only --json can go to the standard output");
  const Status ending = check_picture(options.file);
  if (!ending) return ending;
  if (!options.any()) {
    if (!options.camera.empty()) return bad_input("--camera needs --picture");
    if (!options.size.empty()) return bad_input("--picture-size needs --picture");
    if (options.plain) return bad_input("--picture-plain needs --picture");
  }
  if (!options.camera.empty()) {
    const Result<io::PictureCamera> camera = io::parse_picture_camera("--camera", options.camera);
    if (!camera) return camera.error();
  }
  if (!options.size.empty()) {
    const Result<std::array<std::uint32_t, 2>> size = io::parse_picture_size("--picture-size", options.size);
    if (!size) return size.error();
  }
  return Done{};
}

io::PictureSettings picture_settings(const PictureOptions& options) {
  io::PictureSettings settings;
  if (!options.camera.empty()) settings.camera = io::parse_picture_camera("--camera", options.camera).value();
  if (!options.size.empty()) settings.size_px = io::parse_picture_size("--picture-size", options.size).value();
  settings.plain = options.plain;
  return settings;
}

Result<FilmFrames> FilmFrames::open(const PictureOptions& options) {
  FilmFrames frames;
  if (options.frames_dir.empty()) return frames;
  frames.folder_ = options.frames_dir;
  const Status there = make_folder("--frames-dir", options.frames_dir);
  return there ? Result<FilmFrames>(std::move(frames)) : Result<FilmFrames>(there.error());
}

Status FilmFrames::write(std::uint64_t frame, const io::Image& image) {
  const Result<std::string> png = io::png_bytes(image);
  if (!png) return png.error();
  const Status written =
      io::write_file(std::filesystem::path(folder_) / fmt::format("frame-{:06}.png", frame), png.value());
  if (written) ++written_;
  return written;
}

}  // namespace poise::app
