// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <memory>

#include "parallel/executor.h"
#include "poise/executor.h"

namespace poise::parallel {

/// An executor on a host's threads (poise/executor.h), which take items at a WorkerGate; `threads` in [2, 256], the
/// calling thread included.
std::unique_ptr<Executor> make_host_adapter(std::shared_ptr<HostExecutor> host, int threads,
                                            std::chrono::nanoseconds spin);

}  // namespace poise::parallel
