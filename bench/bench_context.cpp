// SPDX-License-Identifier: MIT
// What every figure is stored with, beside the machine that Google Benchmark names itself.
#include <benchmark/benchmark.h>

#include "build_info.h"

namespace {

const bool kContextAdded = [] {
  benchmark::AddCustomContext("poise_version", POISE_BUILD_VERSION);
  benchmark::AddCustomContext("commit", POISE_BUILD_COMMIT);
  benchmark::AddCustomContext("compiler", POISE_BUILD_COMPILER);
  benchmark::AddCustomContext("flags", POISE_BUILD_FLAGS);
  return true;
}();

}  // namespace
