// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "ledger/unit_costs.h"

namespace poise::ledger {

/// A change of the numbers and its reason.
struct LedgerChange {
  std::string commit;  ///< at which the numbers were counted
  std::string reason;
};

/// The content of bench/ledger.json.
struct Ledger {
  std::string counted_by;  ///< valgrind's version
  std::string compiler;    ///< name and version: numbers of another compiler are not compared
  std::string build;       ///< build type and other settings that affect the generated code
  double tolerance = 0.03;
  std::vector<LedgerChange> changes;  ///< the oldest first
  std::vector<EntryCosts> entries;
};

/// Refused with file and field: not JSON, another schema, a field that is missing or of another type.
Result<Ledger> read_ledger(const std::filesystem::path& file);
Status write_ledger(const Ledger& ledger, const std::filesystem::path& file);

/// One number of two ledgers.
struct Compared {
  std::string entry, cost;
  double before = 0;  ///< 0: not in the ledger
  double now = 0;     ///< 0: not counted
  bool within = false;
};

/// All numbers of both: in the order of `now`, followed by those that only the ledger has. A different count of units
/// gets a line of its own, named `COST count`.
std::vector<Compared> compare(const Ledger& ledger, const std::vector<EntryCosts>& now);

}  // namespace poise::ledger
