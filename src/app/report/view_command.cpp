// SPDX-License-Identifier: MIT
#include "app/report/view_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/files/output_files.h"
#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "app/report/report_page.h"
#include "app/report/report_template.h"
#include "capture/capture_reader.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

struct ViewOptions {
  std::vector<std::string> captures;
  std::string out;
};

std::string page_of(const ViewOptions& options) {
  if (!options.out.empty()) return options.out;
  return std::filesystem::path(options.captures.front()).replace_extension(".html").string();
}

int view(const ViewOptions& options) {
  if (options.out == "-") return refuse("view", kExitBadUsage, "--out: a page cannot go to the standard output");
  for (const std::string& capture : options.captures) {
    if (lower_case_ending(capture) == ".html")
      return refuse("view", kExitBadUsage, capture + ": is a page, which a browser opens; view takes captures");
  }
  const std::string out = page_of(options);
  const std::string& first = options.captures.front();
  const Status apart = check_outputs({{"--out", out}}, {{"CAPTURE", first}, {"CAPTURE", options.captures.back()}});
  if (!apart) return refuse("view", kExitBadUsage, apart.error().message);
  for (const std::string& capture : options.captures) {
    const Status sound = check_capture_file(capture);
    if (!sound) return refuse("view", sound.error());
    // One that was cut short is shown up to there, but without its header and a frame there is nothing to show.
    const Result<capture::CaptureReader> begins = capture::CaptureReader::open(capture);
    if (!begins) return refuse("view", begins.error());
    if (begins.value().frames() == 0) return refuse("view", bad_input(capture + ": has no frames"));
  }
  const Result<std::string> page = read_report_template();
  if (!page) return refuse("view", page.error());
  Result<io::AtomicFile> file = io::AtomicFile::open(out);
  if (!file) return refuse("view", file.error());
  // The command that made a run stands in its capture.
  Status written = write_report_page(page.value(), {{}, {}, {}, options.captures}, file.value());
  if (written) written = file.value().commit();
  if (!written) return refuse("view", written.error());
  written = io::write_stdout(fmt::format("{}\n", out));
  return written ? kExitDone : refuse("view", written.error());
}

}  // namespace

void add_view_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = app.add_subcommand("view", "Make the page of a capture, which any browser opens");
  command->add_option("captures", options->captures, "Files of --capture; two are shown side by side on one clock")
      ->required()
      ->expected(1, 2)
      ->type_name("CAPTURE");
  add_path(*command, "--out", options->out, "The page to write (default: the first capture's name, ending in .html)");
  command->footer(
      "Examples:\n"
      "  poise run jacks --deadline 8 --capture jacks.capture\n"
      "  poise view jacks.capture\n"
      "  poise view narrow.capture wide.capture --out both.html\n\n"
      "It prints the name of the page. Exit codes: 0 done, 2 bad usage, 3 bad input or a page that is not built, 4 "
      "output failed.");
  command->callback([options, &exit_code] { exit_code = view(*options); });
}

}  // namespace poise::app
