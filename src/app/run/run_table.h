// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "scene/run/run_document.h"

namespace poise::app {

/// The figures of a run as a table for a person.
std::string run_table(const io::RunDocument& document);

}  // namespace poise::app
