// SPDX-License-Identifier: MIT
#include <cstdint>

/// Highway's library measures its timer when it is loaded, by an instruction (rdtscp) that it does not ask the
/// processor for. Valgrind ends programs that use it on virtual machines which hide it. Nothing here times by Highway,
/// so programs whose instructions are counted take this in place of that measurement.
namespace hwy::platform {

// NOLINTBEGIN(readability-identifier-naming): the name is Highway's
std::uint64_t TimerResolution();
std::uint64_t TimerResolution() { return 1; }
// NOLINTEND(readability-identifier-naming)

}  // namespace hwy::platform
