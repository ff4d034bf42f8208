// SPDX-License-Identifier: MIT
#include "app/capture/run_capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "app/options/option_values.h"

namespace poise::app {

void add_capture_options(CLI::App& command, CaptureOptions& options) {
  constexpr double kLargestStep = 1e6;
  add_path(command, "--capture", options.file,
           "Write poses, states and camera of every frame, for looking at (docs/capture.md) and poise export");
  command.add_flag("--capture-contacts", options.contacts, "With --capture: contact points too");
  command.add_flag("--capture-pairs", options.pairs,
                   "With --capture: what each pair of near bodies came to in each frame, for the replay of a report");
  add_number(command, "--capture-step", options.step_m, 0, true, kLargestStep,
             "With --capture: positions are rounded to multiples of this (default: about a thousandth of the smallest "
             "radius)")
      ->type_name("M");
}

Status check_capture_options(const CaptureOptions& options) {
  if (options.file == "-") return bad_input("only --json can go to the standard output");
  if (options.file.empty() && options.contacts) return bad_input("--capture-contacts needs --capture");
  if (options.file.empty() && options.pairs) return bad_input("--capture-pairs needs --capture");
  if (options.file.empty() && options.step_m) return bad_input("--capture-step needs --capture");
  return Done{};
}

Result<RunCapture> RunCapture::open(const CaptureOptions& options) {
  RunCapture made;
  made.options_ = options;
  if (options.file.empty()) return made;
  Result<capture::CaptureWriter> writer = capture::CaptureWriter::open(options.file);
  if (!writer) return writer.error();
  made.writer_ = std::move(writer).value();
  return made;
}

void RunCapture::watch(const Scene& scene, SceneRun& run) {
  if (writer_) observer_.emplace(scene, run, options_.contacts, options_.pairs);
}

void RunCapture::pass() {
  if (observer_) observer_->find_levels();
}

Status RunCapture::begin(const Scene& scene, SceneRun& run, capture::CaptureHeader header, WhenFull when_full,
                         const std::optional<capture::FrameFacts>& first) {
  if (!writer_) return Done{};
  header.contacts = options_.contacts;
  header.pairs = options_.pairs;
  header.command = command_line();
  if (options_.step_m) header.position_step_m = *options_.step_m;
  run_ = &run;
  camera_ = header.camera;
  when_full_ = WhenFull::Wait;
  reach_m_ = header.position_step_m * static_cast<double>(capture::kMostSteps);
  if (!observer_) watch(scene, run);
  const Status begun = writer_->begin(header);
  const Status started = begun ? frame(first ? *first : capture::facts_of_start(run.view())) : begun;
  when_full_ = when_full;
  return started;
}

Status RunCapture::frame(capture::FrameFacts facts) {
  if (!writer_) return Done{};
  Status failed = writer_->failure();
  if (failed) failed = reached_;
  if (!failed) return failed;
  if (when_full_ == WhenFull::LeaveOut && !writer_->has_room()) {
    writer_->leave_out();
    return Done{};
  }
  if (camera_) capture::find_gaze(run_->view(), camera_->resolution_px, facts);
  capture::SeenFrame frame = writer_->fresh();
  frame.facts = facts;
  const Status observed = observer_->observe(frame);
  if (!observed) return observed;
  reached_ = within_reach(frame);
  if (reached_) writer_->add(std::move(frame));
  return reached_;
}

Status RunCapture::within_reach(const capture::SeenFrame& frame) const {
  for (const capture::SeenBody& body : frame.bodies) {
    const double most_m = body.pose.position_m.cwiseAbs().maxCoeff();
    if (most_m <= reach_m_) continue;
    return Error{
        ErrorKind::OutputFailed,
        fmt::format("{}: body {} is {:.4g} m from the origin along an axis, and steps of {:.4g} m reach {:.4g} m; "
                    "--capture-step takes longer ones",
                    options_.file, body.number, most_m, reach_m_ / static_cast<double>(capture::kMostSteps), reach_m_)};
  }
  return Done{};
}

Status RunCapture::finish(bool stopped) {
  if (!writer_) return Done{};
  const Status written = writer_->finish(stopped);
  return written ? reached_ : written;
}

std::optional<io::RunDocument::Capture> RunCapture::facts() const {
  if (!writer_) return std::nullopt;
  return io::RunDocument::Capture{options_.file, writer_->frames(), writer_->left_out(), writer_->bytes()};
}

std::vector<std::string> command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::vector<std::string> words;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\0', at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  // The folder of the program says nothing of the run.
  if (!words.empty()) words[0] = std::filesystem::path(words[0]).filename().string();
  return words;
}

}  // namespace poise::app
