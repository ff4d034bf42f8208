// SPDX-License-Identifier: MIT
#pragma once

#include <exception>

#include "arguments.h"
#include "poise/scheduler/policy.h"
#include "poise/world.h"

namespace poise::python {

/// The Python functions of a World: a cue, a policy, a filter of pairs. The World holds plain pointers to this, so it
/// lives as long as the World. Each call takes the global lock, on whichever thread the step makes it, so the calls of
/// all threads come one after another. Invariant: read and written under the global lock alone.
struct HostFunctions {
  py::object cue = py::none();
  py::object policy = py::none();
  py::object filter = py::none();
  std::exception_ptr failure;  ///< the first exception of a function since the step began

  /// Puts the functions that are set into a policy.
  void attach(scheduler::Policy& to);
  /// Raises what a function raised in the step, once.
  void rethrow();
};

/// PairFilter::function with a HostFunctions as context.
bool call_filter(void* context, const FilteredPair& pair);

/// What a policy in Python is asked about: copies of PairChain, whose spans end with the call.
struct ChainFacts {
  scheduler::PairChain chain;
  py::tuple error_m, lifetime_frames, ended;
};

void bind_host_functions(py::module_& module);

}  // namespace poise::python
