// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <utility>

#include "poise/types.h"

namespace poise {

/// What a host's thread does for a step: a copy of this, called once, works until the step has had nothing to do for a
/// short time (WorldSettings::spin), and returns. Copying does not allocate.
///
/// A call may come from any thread, at any time, late or never, from several threads at once, and also when the World
/// is gone: it then returns at once. It does not throw, and it neither waits for other calls nor for the thread that
/// steps.
class HostTask {
 public:
  HostTask() = default;
  void operator()() const {
    if (work_ != nullptr) work_(state_.get());
  }

  /// For src/parallel: `work(state)` is the call, `state` lives as long as any copy.
  HostTask(std::shared_ptr<void> state, void (*work)(void*)) : state_(std::move(state)), work_(work) {}

 private:
  std::shared_ptr<void> state_;
  void (*work_)(void*) = nullptr;
};

/// A host's own job system, which lends its threads to the step: what enqueueTask is to Box3D and JobSystem to Jolt.
/// Give it to a World with WorldSettings::executor = ExecutorKind::Host and WorldSettings::host_executor.
///
/// The contract is small because Poise waits for items of work, never for workers. The thread that calls World::step
/// works through all items itself; whoever calls a HostTask takes items from the same tickets. So a host may start
/// fewer calls than it was asked for, start them late, or none at all: the step only takes longer. Its result is the
/// same to the bit. Once a call has taken an item, the step waits for that item (under a deadline, refinement abandons
/// it when its time is over).
class HostExecutor {
 public:
  virtual ~HostExecutor() = default;

  /// Threads that may work on one step at once, the calling thread included, in [1, 256]. Asked once, when the World is
  /// created.
  [[nodiscard]] virtual int concurrency() const = 0;

  /// Asks for `count` calls of `task` (at least 1) on other threads, soon. Returns at once, without waiting for them;
  /// must not throw. Called by the thread that steps, several times a frame, and only for calls that are not pending or
  /// running already. Says how many of the calls will be made, in [0, count]: each of these must be made once, sooner
  /// or later; the others are asked for again at the next occasion.
  virtual int start(int count, const HostTask& task) = 0;
};

}  // namespace poise
