// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "assets/files/atomic_file.h"
#include "poise/result.h"

namespace poise::io {

using geometry::AtomicFile;
using geometry::write_file;

/// Writes to the standard output and flushes it. Refused as OutputFailed.
Status write_stdout(std::string_view text);

}  // namespace poise::io
