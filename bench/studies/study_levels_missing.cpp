// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cstdio>

#include "app/process/exit_codes.h"
#include "app/process/standard_streams.h"
#include "studies/study_levels.h"

namespace poise::app {

// Replaces study_levels_run.cpp if the oracle could not be built.
int study_levels(const StudyLevelsOptions&) {
  print_error("poise study levels: this program was built without libfcl-dev, the exact oracle\n");
  return kExitBadUsage;
}

}  // namespace poise::app
