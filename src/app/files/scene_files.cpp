// SPDX-License-Identifier: MIT
#include "app/files/scene_files.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>

#include "scene/field_reader.h"

namespace poise::app {
namespace {

std::vector<std::filesystem::path> scenes_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code failure;
  std::filesystem::directory_iterator entry(folder, failure);
  for (; !failure && entry != std::filesystem::directory_iterator(); entry.increment(failure)) {
    if (entry->path().extension() == ".json") files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<std::filesystem::path> shipped_scenes() {
  std::error_code failure;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failure);
  const std::array<std::filesystem::path, 3> folders{program.parent_path().parent_path() / "share" / "poise" / "scenes",
                                                     POISE_SCENES_SOURCE_DIR, POISE_SCENES_INSTALL_DIR};
  for (const std::filesystem::path& folder : folders) {
    std::vector<std::filesystem::path> files = scenes_in(folder);
    if (!files.empty()) return files;
  }
  return {};
}

Result<std::filesystem::path> find_scene(const std::string& scene) {
  const bool is_name = scene.find('/') == std::string::npos && scene.find('.') == std::string::npos;
  if (!is_name) return std::filesystem::path(scene);
  std::string listed;
  std::vector<std::string> names;
  for (const std::filesystem::path& file : shipped_scenes()) {
    if (file.stem() == scene) return file;
    names.push_back(file.stem().string());
    listed += (listed.empty() ? "" : ", ") + names.back();
  }
  const std::vector<std::string_view> views(names.begin(), names.end());
  return bad_input(scene + ": no scene of this name ships (" + listed + "); a file needs a path such as ./" + scene +
                   io::suggestion(scene, views));
}

}  // namespace poise::app
