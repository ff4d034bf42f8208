// SPDX-License-Identifier: MIT
#include "app/live/live_page.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <system_error>

namespace poise::app {

std::vector<std::filesystem::path> live_page_places() {
  std::error_code failure;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failure);
  return {program.parent_path().parent_path() / "share" / "poise" / "live.html", POISE_LIVE_SOURCE, POISE_LIVE_INSTALL};
}

Result<std::string> read_live_page(const std::vector<std::filesystem::path>& places) {
  std::string looked;
  for (const std::filesystem::path& place : places) {
    looked += (looked.empty() ? "" : ", ") + place.string();
    std::ifstream file(place, std::ios::binary);
    if (!file) continue;
    std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.find(kLiveMark) != std::string::npos) return text;
    return bad_input(fmt::format("{}: no page for live runs: the line {} is not in it", place.string(), kLiveMark));
  }
  return bad_input(
      fmt::format("the page for live runs is not built (looked for {}): cmake/build_viewer.sh in the source builds it, "
                  "with node 18 or later and npm",
                  looked));
}

}  // namespace poise::app
