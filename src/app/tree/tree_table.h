// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "app/tree/tree_document.h"

namespace poise::app {

/// The figures of one tree for a person, or of two side by side with the better one marked.
std::string tree_table(const io::TreeDocument& document);

}  // namespace poise::app
