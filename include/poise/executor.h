// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <utility>

#include "poise/types.h"

namespace poise {

/// The work of one step that a host's thread may take part in. Each call of a copy works until the step has had no work
/// for a short time (WorldSettings::spin), and then returns. Copying does not allocate.
///
/// Any thread may call it, several threads at once, at any time. It may be called late, never, or after the World was
/// destroyed: the call then returns at once. It does not throw. It waits neither for other calls nor for the thread
/// that steps.
class HostTask {
 public:
  HostTask() = default;
  void operator()() const {
    if (work_ != nullptr) work_(state_.get());
  }

  /// For src/parallel. A call runs `work(state)`; `state` is alive as long as any copy.
  HostTask(std::shared_ptr<void> state, void (*work)(void*)) : state_(std::move(state)), work_(work) {}

 private:
  std::shared_ptr<void> state_;
  void (*work_)(void*) = nullptr;
};

/// A host's own job system, which lends its threads to the step: the counterpart of enqueueTask in Box3D and JobSystem
/// in Jolt. Set WorldSettings::executor = ExecutorKind::Host and WorldSettings::host_executor to use it.
///
/// The step waits for items of work, never for workers. The thread that calls World::step takes items until none is
/// left; each call of a HostTask takes items from the same shared counter. So a host may start fewer calls than it was
/// asked for, start them late, or start none: the step then takes longer, and its result is the same to the bit. Once a
/// call has taken an item, the step waits for that item (under a deadline, refinement abandons the item when its time
/// is over).
class HostExecutor {
 public:
  virtual ~HostExecutor() = default;

  /// Threads that may work on one step at once, the calling thread included, in [1, 256]. Asked once, when the World is
  /// created.
  [[nodiscard]] virtual int concurrency() const = 0;

  /// Asks for `count` (at least 1) calls of `task` on other threads, soon. Returns at once without waiting for them,
  /// and must not throw. The thread that steps (with StepInput::may_slice one of the World in its place) calls it
  /// several times a frame, and only for calls that are neither pending nor running. Returns how many of the calls will
  /// be made, in [0, count]. Each must be made once, sooner or later; the step asks for the others again later.
  virtual int start(int count, const HostTask& task) = 0;
};

}  // namespace poise
