// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <type_traits>

namespace poise::parallel {

/// A reference to a callable that takes a worker's number, without ownership or allocation; valid while the callable
/// lives. The callable does one item of work and returns whether there may be more for this worker. One that returns
/// void is called once.
class WorkerFunction {
 public:
  WorkerFunction() = default;
  template <class F>
  requires(!std::is_same_v<std::remove_cvref_t<F>, WorkerFunction>)
      // NOLINTNEXTLINE(google-explicit-constructor): made at the call, lives as long as the call
      WorkerFunction(F&& f)
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(f)))),
        call_([](void* object, int worker) -> bool {
          auto& callable = *static_cast<std::remove_reference_t<F>*>(object);
          if constexpr (std::is_void_v<std::invoke_result_t<std::remove_reference_t<F>&, int>>) {
            callable(worker);
            return false;
          } else {
            return callable(worker);
          }
        }) {}
  bool operator()(int worker) const { return call_(object_, worker); }

 private:
  void* object_ = nullptr;
  bool (*call_)(void*, int) = nullptr;
};

}  // namespace poise::parallel
