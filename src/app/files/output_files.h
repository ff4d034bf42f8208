// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <optional>
#include <string>

#include "poise/result.h"
#include "scene/result_file.h"

namespace poise::app {

/// A file on the command line, and what it was named for. An empty path was not given; "-" is the standard output.
struct NamedFile {
  const char* option;
  const std::string& path;
};

/// Refuses two outputs into one file, and an output into a file that is also read. Several may be "-"; pipes and
/// devices are no files that could be overwritten.
Status check_outputs(std::initializer_list<NamedFile> outputs, std::initializer_list<NamedFile> inputs);

/// The ending of a file's name with its dot, `A` to `Z` made small; empty for none.
std::string lower_case_ending(const std::string& path);

/// Refuses a picture whose name says that it is no PNG. A name without an ending is taken.
Status check_picture(const std::string& path, const char* option = "--picture");

/// Tells all paths that cannot be written before long work, in one message, without leaving anything there. A pipe or a
/// device is not tried: opening it is felt.
Status can_write(std::initializer_list<std::string> paths);

/// Opens a file, unless none is asked for or it is the standard output; adds to `all` why it cannot be written.
std::optional<io::AtomicFile> open_file(const std::string& path, Status& all);

/// Makes a folder, and those that it is in. Refused with the option, and why.
Status make_folder(const char* option, const std::string& path);

/// Writes to a file, or to the standard output for "-"; nothing for an empty path.
Status write_to(const std::string& path, const std::string& text);

}  // namespace poise::app
