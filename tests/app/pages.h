// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "app/command.h"

namespace poise::testing {

/// What stands in the script element with this id; empty where there is none.
std::string embedded(const std::string& page, const std::string& id);

/// Names of what is in a folder, in order.
std::vector<std::string> files_in(const std::string& folder);

/// Expects the refusal of a command whose page is not built, before it made its folder.
void expect_no_page(const CommandResult& result, const std::string& folder);

/// The state hash of a short run of jacks on the work clock with more options.
std::string hash_of_jacks(const std::vector<std::string>& more = {});

}  // namespace poise::testing
