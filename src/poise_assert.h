// SPDX-License-Identifier: MIT
#pragma once

/// A caller's mistake that cannot come from data. On in tests and the dev preset; in a release build the condition is
/// compiled but not evaluated, and the code after it does nothing harmful.
#if defined(POISE_ASSERTIONS)
#define POISE_ASSERT(condition) ((condition) ? static_cast<void>(0) : __builtin_trap())
#else
#define POISE_ASSERT(condition) (static_cast<void>(sizeof(!(condition))))
#endif
