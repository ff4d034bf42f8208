// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

/// What stands around the content of binary files, for a fuzzer does not find a checksum, and readers of files that are
/// the command's alone.
namespace poise::fuzz {

/// Each block of a record with the checksum of its bytes, as far as the lengths lead.
std::string with_record_checksums(std::string_view bytes);
/// A cache entry with the checksum of its bytes and an empty key.
std::string with_entry_checksum(std::string_view bytes);
/// A whole capture with its checksums put right, or one chunk of it: the first byte says which.
bool read_capture(std::string_view bytes);

/// The specification of a sweep, and the files in its folder: what a task is given, how a trial ended, what it found.
bool read_sweep_spec(std::string_view bytes);
bool read_trials(std::string_view bytes);
bool read_outcome(std::string_view bytes);
bool read_run_result(std::string_view bytes);

}  // namespace poise::fuzz
