// SPDX-License-Identifier: MIT
// Empty: this target exists for its precompiled header.
