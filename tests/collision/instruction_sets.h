// SPDX-License-Identifier: MIT
#pragma once

#include <hwy/targets.h>

#include <cstdint>
#include <type_traits>

namespace poise::collision {

/// Calls work(), or work(its name), once for each instruction set of this machine that the kernels were compiled for.
/// No other thread may run kernels meanwhile. Returns the number of calls.
template <class Work>
int on_every_instruction_set(Work&& work) {
  int sets = 0;
  for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1) {
    hwy::GetChosenTarget().Update(left & -left);
    if constexpr (std::is_invocable_v<Work, const char*>) {
      work(hwy::TargetName(left & -left));
    } else {
      work();
    }
    ++sets;
  }
  hwy::GetChosenTarget().DeInit();
  return sets;
}

}  // namespace poise::collision
