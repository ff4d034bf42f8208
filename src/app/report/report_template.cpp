// SPDX-License-Identifier: MIT
#include "app/report/report_template.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <system_error>

#include "app/report/report_page.h"

namespace poise::app {

std::vector<std::filesystem::path> report_template_places() {
  std::error_code failure;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failure);
  return {program.parent_path().parent_path() / "share" / "poise" / "report.html", POISE_REPORT_SOURCE,
          POISE_REPORT_INSTALL};
}

Result<std::string> read_report_template(const std::vector<std::filesystem::path>& places) {
  for (const std::filesystem::path& place : places) {
    std::ifstream file(place, std::ios::binary);
    if (!file) continue;
    std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.find(kReportData) != std::string::npos) return text;
    return bad_input(fmt::format("{}: no page for reports: the line {} is not in it", place.string(), kReportData));
  }
  std::string looked;
  for (const std::filesystem::path& place : places) looked += (looked.empty() ? "" : ", ") + place.string();
  return bad_input(
      fmt::format("the page for reports is not built (looked for {}): cmake/build_viewer.sh in the source builds it, "
                  "with node 18 or later and npm",
                  looked));
}

}  // namespace poise::app
