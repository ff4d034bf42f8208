// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

// Stands in for the tests of the oracle where it is missing, so that the report says so.
TEST(Oracle, IsExact) { GTEST_SKIP() << "libfcl-dev was not there when this was built"; }
