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
  double instructions = 0;  ///< per frame for a stage, per unit for a unit
  double count = 0;         ///< frames or units in the mean
};

struct EntryCosts {
  std::string entry;
  std::vector<Cost> per_frame;  ///< the step and its stages
  std::vector<Cost> per_unit;   ///< without units with fewer than 30 in the entry
};

/// Divides callgrind's counts among the stages and units of work. Refused if the stages of the table make up less than
/// 95 % of the step: then a stage was renamed or added, and the table in unit_costs.cpp must be updated.
Result<EntryCosts> unit_costs(const std::string& entry, const CallgrindProfile& profile, const CountedUnits& units);

}  // namespace poise::ledger
