// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "ledger/callgrind_profile.h"
#include "ledger/workload.h"

namespace poise::ledger {

/// One number of the ledger.
struct Cost {
  std::string name;         ///< "step", a stage, or a unit
  double instructions = 0;  ///< per frame of a stage, per unit of a unit
  double count = 0;         ///< frames or units that it is the mean over
};

struct EntryCosts {
  std::string entry;
  std::vector<Cost> per_frame;  ///< the step and its stages
  std::vector<Cost> per_unit;   ///< without units of which the entry has fewer than 30
};

/// Divides what callgrind counted among the stages and units of work. Refused: the stages of the table make up less
/// than 95 % of the step, so that a stage was renamed or is new and the table in unit_costs.cpp is to be mended.
Result<EntryCosts> unit_costs(const std::string& entry, const CallgrindProfile& profile, const CountedUnits& units);

}  // namespace poise::ledger
