// SPDX-License-Identifier: MIT
#include "app/report/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "assets/files/open_file.h"
#include "capture/chunks.h"

namespace poise::app {
namespace {

/// A `<` could end the element of a script. In JSON it only stands in strings, where this means the same.
std::string without_markup(const std::string& text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string element(std::string_view id, std::string_view type, const std::string& text) {
  return fmt::format("<script type=\"{}\" id=\"{}\">{}</script>\n", type, id, text);
}

bool is_plain(const std::string& word) {
  if (word.empty()) return false;
  for (const char c : word) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && std::strchr("-_./,:=+@%", c) == nullptr) return false;
  }
  return true;
}

/// In blocks, since a capture may be large.
Status write_capture(const std::string& path, io::AtomicFile& file) {
  constexpr std::size_t kBlock = std::size_t{3} << 18U;  // whole groups of three, so that blocks need no padding
  const Result<geometry::OpenFile> capture = geometry::OpenFile::open(path);
  if (!capture) return bad_input(path + ": " + capture.error().message);
  const std::uint64_t size = capture.value().bytes();
  std::string block;
  std::string text;
  for (std::uint64_t at = 0; at < size; at += block.size()) {
    block.resize(std::min<std::uint64_t>(kBlock, size - at));
    if (!capture.value().read(at, block)) return bad_input(path + ": could not be read to its end");
    text.clear();
    append_base64(block, text);
    const Status written = file.write(text);
    if (!written) return written;
  }
  return Done{};
}

/// What tells files apart for a reader: their names, or where these are the same, those of their folders too.
std::vector<std::string> names_of(const std::vector<std::string>& paths) {
  std::vector<std::string> names, whole;
  for (const std::string& path : paths) {
    std::error_code ignored;
    const std::filesystem::path full = std::filesystem::absolute(path, ignored).lexically_normal();
    names.push_back(full.filename().string());
    whole.push_back((full.parent_path().filename() / full.filename()).string());
  }
  const bool alike = names.size() == 2 && names[0] == names[1] && whole[0] != whole[1];
  return alike ? whole : names;
}

}  // namespace

std::string data_element(std::string_view id, std::string_view type, const std::string& json) {
  return element(id, type, without_markup(json));
}

std::string shell_line(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (is_plain(word)) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

void append_base64(std::string_view bytes, std::string& out) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto byte = [&](std::size_t at) {
    return at < bytes.size() ? std::uint32_t{static_cast<unsigned char>(bytes[at])} : 0U;
  };
  out.reserve(out.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::uint32_t group = byte(at) << 16U | byte(at + 1) << 8U | byte(at + 2);
    out += kLetters[group >> 18U & 63U];
    out += kLetters[group >> 12U & 63U];
    out += at + 1 < bytes.size() ? kLetters[group >> 6U & 63U] : '=';
    out += at + 2 < bytes.size() ? kLetters[group & 63U] : '=';
  }
}

Status check_capture_file(const std::string& path) {
  const Result<geometry::OpenFile> file = geometry::OpenFile::open(path);
  if (!file) return bad_input(path + ": " + file.error().message);
  const std::uint64_t size = file.value().bytes();
  std::array<char, capture::kMagic.size()> begin{};
  if (!file.value().read(0, begin) || std::string_view(begin.data(), begin.size()) != capture::kMagic)
    return bad_input(path + ": not a capture of this version (poise.capture/1)");
  if (size > kMostCaptureBytes) {
    return bad_input(
        fmt::format("{}: {} bytes, must be at most {} for a page: capture fewer frames or bodies, or with a "
                    "larger --capture-step",
                    path, size, kMostCaptureBytes));
  }
  return Done{};
}

Status write_report_page(const std::string& page, const ReportParts& parts, io::AtomicFile& file) {
  const std::size_t place = page.find(kReportData);
  std::string data = page.substr(0, place);
  nlohmann::ordered_json about = {{"command", shell_line(parts.command)}};
  for (const std::string& name : names_of(parts.captures)) about["captures"].push_back(name);
  const auto replace = nlohmann::ordered_json::error_handler_t::replace;
  data += data_element("poise-page", "application/json", about.dump(-1, ' ', false, replace));
  if (!parts.run_json.empty()) data += data_element("poise-run", "application/json", parts.run_json);
  if (!parts.frames_csv.empty()) data += element("poise-frames", "text/csv", parts.frames_csv);
  Status written = file.write(data);
  for (std::size_t k = 0; k < parts.captures.size() && written; ++k) {
    written = check_capture_file(parts.captures[k]);
    if (!written) return written;
    written = file.write(
        fmt::format("<script type=\"application/octet-stream\" id=\"poise-capture{}\">", k == 0 ? "" : "-b"));
    if (written) written = write_capture(parts.captures[k], file);
    if (written) written = file.write("</script>\n");
  }
  return written ? file.write(page.substr(place + kReportData.size())) : written;
}

}  // namespace poise::app
