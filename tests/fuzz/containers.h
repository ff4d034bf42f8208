// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

/// What stands around the content of binary files: a fuzzer does not find a checksum, so that they are put right.
namespace poise::fuzz {

/// Each block of a record with the checksum of its bytes, as far as the lengths lead.
std::string with_record_checksums(std::string_view bytes);
/// A cache entry with the checksum of its bytes and an empty key.
std::string with_entry_checksum(std::string_view bytes);
/// A whole capture with its checksums put right, or one chunk of it: the first byte says which.
bool read_capture(std::string_view bytes);

}  // namespace poise::fuzz
