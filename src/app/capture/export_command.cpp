// SPDX-License-Identifier: MIT
#include "app/capture/export_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/files/output_files.h"
#include "app/options/frame_range.h"
#include "app/options/option_values.h"
#include "app/picture/drawn_frame.h"
#include "app/picture/frame_picture.h"
#include "app/picture/picture_options.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "capture/export/figures_csv.h"
#include "capture/export/gltf.h"
#include "capture/export/paraview.h"
#include "parallel/interrupt.h"
#include "poise/scene/scene.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

constexpr std::string_view kStoppedExport = "files that were not complete were not written";

struct ExportOptions {
  std::string capture, gltf, pvd, csv, frames;
  std::optional<std::uint64_t> frame, every;
  PictureOptions picture;
  bool quiet = false;
};

Result<capture::FrameChoice> choice_of(const ExportOptions& options) {
  capture::FrameChoice choice;
  if (options.frame) {
    choice.from = choice.to = *options.frame;
  } else if (!options.frames.empty()) {
    const Result<FrameRange> frames = parse_frame_range(options.frames);
    if (!frames) return frames.error();
    choice.from = frames.value().from;
    choice.to = frames.value().to;
  }
  choice.every = options.every.value_or(1);
  return choice;
}

Status check(const ExportOptions& options) {
  if (options.gltf.empty() && options.pvd.empty() && options.csv.empty() && !options.picture.any())
    return bad_input("one of --gltf, --pvd, --csv, --picture and --frames-dir is required");
  if (options.frame && !options.frames.empty()) return bad_input("--frame and --frames cannot both be given");
  if (options.frame && options.every) return bad_input("--every has no meaning with --frame");
  if (options.gltf == "-" || options.pvd == "-") return bad_input("only --csv can go to the standard output");
  const std::string ending = lower_case_ending(options.gltf);
  if (!ending.empty() && ending != ".glb")
    return bad_input(fmt::format("--gltf {}: a binary glTF is written, so the ending must be .glb", options.gltf));
  const Status pictures = check_picture_options(options.picture);
  if (!pictures) return pictures;
  const Result<capture::FrameChoice> choice = choice_of(options);
  if (!choice) return choice.error();
  return check_outputs({{"--gltf", options.gltf}, {"--csv", options.csv}, {"--picture", options.picture.file}},
                       {{"CAPTURE", options.capture}});
}

Status write_gltf(capture::CaptureReader& reader, const capture::FrameChoice& choice, const std::string& path,
                  const parallel::Interrupt& interrupt) {
  const Result<std::string> glb = capture::gltf_bytes(reader, choice, [&] { return !interrupt.asked(); });
  if (interrupt.asked()) return stopped_error(kStoppedExport);
  return glb ? io::write_file(path, glb.value()) : Status(glb.error());
}

Status write_csv(capture::CaptureReader& reader, const capture::FrameChoice& choice, const std::string& path,
                 const parallel::Interrupt& interrupt) {
  std::string text = capture::figures_header();
  const Status read = capture::read_chosen(reader, choice, [&](const capture::PackedFrame& frame) {
    text += capture::figures_row(frame);
    return !interrupt.asked();
  });
  if (interrupt.asked()) return stopped_error(kStoppedExport);
  return read ? write_to(path, text) : read;
}

Status write_pvd(capture::CaptureReader& reader, const capture::FrameChoice& choice, const std::string& path,
                 const parallel::Interrupt& interrupt) {
  const std::filesystem::path folder(path);
  const Status there = make_folder("--pvd", path);
  if (!there) return there.error();
  capture::FrameDrawer drawer(reader);
  std::vector<std::pair<double, std::string>> files;
  Status written = Done{};
  double reach_m = 1;
  const Status read = capture::read_chosen(reader, choice, [&](const capture::PackedFrame& frame) {
    files.emplace_back(frame.facts.time_s, fmt::format("frame-{:06}.vtp", frame.facts.frame));
    written = io::write_file(folder / files.back().second, drawer.vtp(frame));
    for (std::size_t i = 0; i < frame.rows.size(); ++i) {
      if (reader.bodies()[frame.rows[i]].motion != MotionType::Static)
        reach_m = std::max(reach_m, reader.pose(frame.poses[i]).position_m.norm());
    }
    return written.ok() && !interrupt.asked();
  });
  if (interrupt.asked()) return stopped_error(kStoppedExport);
  if (!read || !written) return read ? written : read;
  const std::vector<capture::CapturedShape>& shapes = reader.header().shapes;
  for (std::size_t i = 0; i < shapes.size() && written; ++i)
    written = io::write_file(folder / fmt::format("shape-{}.vtp", i), capture::shape_vtp(shapes[i], 1.2 * reach_m));
  return written ? io::write_file(folder / "run.pvd", capture::pvd(files)) : written;
}

/// Every chosen frame into the folder, and the last of them into the file.
Status write_pictures(capture::CaptureReader& reader, const capture::FrameChoice& choice, const PictureOptions& options,
                      const parallel::Interrupt& interrupt) {
  Result<FilmFrames> film = FilmFrames::open(options);
  if (!film) return film.error();
  const io::FramePictures pictures(reader.header().shapes, picture_settings(options));
  std::optional<io::DrawnFrame> last;
  Status written = Done{};
  const Status read = capture::read_chosen(reader, choice, [&](const capture::PackedFrame& frame) {
    last = io::drawn_frame(reader, frame);
    if (film.value().on()) written = film.value().write(frame.facts.frame, pictures.draw(*last));
    return written.ok() && !interrupt.asked();
  });
  if (interrupt.asked()) return stopped_error(kStoppedExport);
  if (!read || !written || options.file.empty()) return read ? written : read;
  const Result<std::string> png = io::png_bytes(pictures.draw(last.value()));
  return png ? io::write_file(options.file, png.value()) : Status(png.error());
}

std::string summary(const capture::CaptureReader& reader) {
  const capture::CaptureHeader& header = reader.header();
  std::string text = fmt::format("{}: {}, {} frames of {:.4g} ms, {} bodies, {} shapes; positions to {:.3g} m\n",
                                 reader.name(), header.scene, reader.frames(), 1000 * header.dt_s,
                                 reader.bodies().size(), header.shapes.size(), header.position_step_m / 2);
  if (!reader.end()) return text;
  if (reader.end()->left_out > 0)
    text += fmt::format("{} frames were left out when it was written\n", reader.end()->left_out);
  if (reader.end()->stopped) text += "its run was stopped by Ctrl-C or SIGTERM\n";
  return text;
}

int export_capture(const ExportOptions& options) {
  const Status sound = check(options);
  if (!sound) return refuse("export", kExitBadUsage, sound.error().message);
  const capture::FrameChoice choice = choice_of(options).value();
  Result<capture::CaptureReader> reader = capture::CaptureReader::open(options.capture);
  if (!reader) return refuse("export", reader.error());
  const parallel::Interrupt interrupt;
  Status writable = can_write({options.gltf, options.csv, options.picture.file});
  if (!options.pvd.empty()) add_failure(make_folder("--pvd", options.pvd), writable);
  if (const Result<FilmFrames> film = FilmFrames::open(options.picture); !film) add_failure(film.error(), writable);
  if (!writable) return refuse("export", writable.error());
  if (const auto& damage = reader.value().damage()) {
    print_error("poise export: warning: {}: byte {}: {}; the {} frames before it are read\n", options.capture,
                damage->byte, damage->what, reader.value().frames());
  }
  Status written = Done{};
  bool left_out = false;
  const auto write = [&](bool wanted, const auto& output) {
    if (!wanted) return;
    left_out = left_out || interrupt.asked();
    if (!left_out) add_failure(output(), written);
  };
  capture::CaptureReader& frames = reader.value();
  write(!options.csv.empty(), [&] { return write_csv(frames, choice, options.csv, interrupt); });
  write(!options.gltf.empty(), [&] { return write_gltf(frames, choice, options.gltf, interrupt); });
  write(!options.pvd.empty(), [&] { return write_pvd(frames, choice, options.pvd, interrupt); });
  write(options.picture.any(), [&] { return write_pictures(frames, choice, options.picture, interrupt); });
  if (written && left_out) written = stopped_error(kStoppedExport);
  if (written && !options.quiet && options.csv != "-") written = write_to("-", summary(reader.value()));
  return written ? kExitDone : refuse("export", written.error());
}

}  // namespace

void add_export_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command =
      app.add_subcommand("export", "Make pictures, glTF, ParaView files or tables of a capture (poise run --capture)");
  command->add_option("capture", options->capture, "A file of poise run --capture")->required()->type_name("CAPTURE");
  add_path(*command, "--gltf", options->gltf, "Write a binary glTF (.glb) with an animation, for Blender or three.js");
  add_path(*command, "--pvd", options->pvd,
           "Write a folder for ParaView: run.pvd, and a .vtp for each frame and shape");
  add_path(*command, "--csv", options->csv,
           "Write times, counts and causes as CSV, one row a frame, - for the standard output");
  add_picture_options(*command, options->picture, "the last of the chosen frames");
  add_frames_dir(*command, options->picture, "all chosen ones");
  add_whole(*command, "--frame", options->frame, 0, kMaxSceneFrames, "This frame alone; 0 is the start");
  command->add_option("--frames", options->frames, "The frames from A to B alone (default: all)")->type_name("A..B");
  add_whole(*command, "--every", options->every, 1, kMaxSceneFrames, "Each N-th of these frames alone (default 1)");
  command->add_flag("--quiet", options->quiet, "No summary");
  command->footer(
      "Examples:\n"
      "  poise run jacks --bodies 500 --capture jacks.capture\n"
      "  poise export jacks.capture --gltf jacks.glb --every 2\n"
      "  poise export jacks.capture --gltf heap.glb --frame 300\n"
      "  poise export jacks.capture --csv - --frames 100..200\n"
      "  poise export jacks.capture --picture heap.png --frame 300 --camera 9,-9,6:0,0,1\n"
      "  poise export jacks.capture --frames-dir film --every 2\n\n"
      "A capture that ends early, because its run was killed, is read up to there (docs/capture.md).\n"
      "Exit codes: 0 done, 2 bad usage, 3 bad input, 4 output failed, 130 stopped by Ctrl-C, 143 by SIGTERM.");
  command->callback([options, &exit_code] { exit_code = export_capture(*options); });
}

}  // namespace poise::app
