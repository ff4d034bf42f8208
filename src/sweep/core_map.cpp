// SPDX-License-Identifier: MIT
#include "sweep/core_map.h"

#include <algorithm>

namespace poise::sweep {

CoreMap::CoreMap(std::vector<int> processors) {
  std::ranges::sort(processors);
  for (const int processor : processors) cores_.push_back({processor, 0, false});
}

std::optional<std::vector<int>> CoreMap::take(std::size_t count, Use use) {
  if (use != Use::Alone) count = std::min(count, cores_.size());
  std::vector<Core*> free;
  for (Core& core : cores_) {
    if (!core.alone && (core.users == 0 || use == Use::Shared)) free.push_back(&core);
  }
  if (count == 0 || free.size() < count) return std::nullopt;
  std::ranges::stable_sort(free, {}, &Core::users);
  free.resize(count);
  std::vector<int> taken;
  for (Core* core : free) {
    ++core->users;
    core->alone = use == Use::Alone;
    taken.push_back(core->processor);
  }
  std::ranges::sort(taken);
  return taken;
}

void CoreMap::give_back(const std::vector<int>& processors) {
  for (const int processor : processors) {
    const auto core = std::ranges::find(cores_, processor, &Core::processor);
    if (core == cores_.end() || core->users == 0) continue;
    --core->users;
    core->alone = false;
  }
}

}  // namespace poise::sweep
