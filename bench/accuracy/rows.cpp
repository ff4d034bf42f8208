// SPDX-License-Identifier: MIT
#include <cmath>

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

bool Row::ok() const { return std::isfinite(value) && (!at_most || value <= *at_most); }

void Context::add(std::string figure, std::string unit, double value, std::optional<double> at_most,
                  std::string published) {
  rows.push_back({case_name, std::move(figure), std::move(unit), value, at_most, std::move(published)});
}

Status Context::at(double share) const {
  if (stop.stop_requested()) return Error{ErrorKind::Cancelled, "stopped; nothing was written"};
  if (progress) progress(share);
  return Done{};
}

WorldSettings Context::world_settings() const {
  WorldSettings settings;
  settings.executor = executor;
  settings.threads = threads;
  settings.max_front_entries = 1U << 18U;
  return settings;
}

bool matches(std::string_view name, std::string_view pattern) {
  for (;;) {
    const std::size_t star = pattern.find('*');
    const std::string_view part = pattern.substr(0, star);
    const std::size_t at = name.find(part);
    if (at == std::string_view::npos) return false;
    if (star == std::string_view::npos) return true;
    name.remove_prefix(at + part.size());
    pattern.remove_prefix(star + 1);
  }
}

}  // namespace poise::accuracy
