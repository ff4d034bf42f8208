// SPDX-License-Identifier: MIT
#pragma once

#include "app/tree/tree_options.h"

namespace poise::app {

/// `poise tree --inspect`: what each mesh is and what follows from it, as a table or JSON (poise.mesh-reports/1).
/// Returns the exit code: a file that is refused is a row like the others, unless all of them are.
int print_mesh_reports(const TreeOptions& options);

}  // namespace poise::app
