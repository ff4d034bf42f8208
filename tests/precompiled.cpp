// SPDX-License-Identifier: MIT
// Empty: what this target is there for is its precompiled header.
