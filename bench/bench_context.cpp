// SPDX-License-Identifier: MIT
// The context that is stored with every figure, in addition to the machine that Google Benchmark names itself.
#include <benchmark/benchmark.h>

#include "scene/made_by.h"

namespace {

const bool kContextAdded = [] {
  const poise::io::BuildFacts build = poise::io::this_build();
  benchmark::AddCustomContext("poise_version", build.version);
  benchmark::AddCustomContext("commit", build.commit);
  benchmark::AddCustomContext("compiler", build.compiler);
  benchmark::AddCustomContext("flags", build.flags);
  return true;
}();

}  // namespace
