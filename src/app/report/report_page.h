// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "scene/result_file.h"

namespace poise::app {

/// The line of the template that the data of a run takes the place of.
inline constexpr std::string_view kReportData = "<!-- poise:data -->";

/// The largest capture that a page may hold. Browsers take texts below 512 MiB, and base64 makes it a third longer.
inline constexpr std::uint64_t kMostCaptureBytes = std::uint64_t{256} << 20U;

/// What a page is made of; an empty part is left out.
struct ReportParts {
  std::vector<std::string> command;   ///< words of the command line
  std::string run_json;               ///< `poise.run`
  std::string frames_csv;             ///< as `--frames-csv`
  std::vector<std::string> captures;  ///< files, two at most
};

/// `words` as one line that a shell would read as the same words.
std::string shell_line(const std::vector<std::string>& words);

/// An element of a page that holds JSON, in which no markup can stand.
std::string data_element(std::string_view id, std::string_view type, const std::string& json);

/// Appends the base64 of `bytes` (RFC 4648, with padding).
void append_base64(std::string_view bytes, std::string& out);

/// Writes the template with the data in its place; the file is not committed. Refused: a capture that cannot be read
/// or is too large, and what the file refuses.
Status write_report_page(const std::string& page, const ReportParts& parts, io::AtomicFile& file);

/// Refused: a file that cannot be read, is no capture, or has more than kMostCaptureBytes.
Status check_capture_file(const std::string& path);

}  // namespace poise::app
