// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace poise::testing {

/// The outputs of `poise run` in a folder, as options: all that it writes beside a page.
std::vector<std::string> all_outputs(const std::string& folder);

/// What a run left in its folder. A number of frames is empty where the file is not there.
struct LeftFiles {
  bool json = false;                                  ///< there, and whole
  std::optional<std::uint64_t> json_frames;           ///< measured frames that the JSON names
  std::optional<std::uint64_t> frames_csv, states;    ///< rows of frames; frames in the table of states
  std::optional<std::uint64_t> record, record_part;   ///< frames up to where it ends
  std::optional<std::uint64_t> capture, states_part;  ///< likewise; the start counts
  bool record_whole = false, capture_whole = false;   ///< they have their end
  std::vector<std::string> parts;                     ///< names of files that end in `.part`
  std::vector<std::string> problems;                  ///< what is there and cannot be read up to where it ends
};
LeftFiles read_left_files(const std::string& folder);

}  // namespace poise::testing
