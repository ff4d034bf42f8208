// SPDX-License-Identifier: MIT
#include "parallel/interrupt.h"

#include <gtest/gtest.h>

#include <csignal>
#include <semaphore>

namespace poise::parallel {
namespace {

// Counts calls of the previous SIGINT handler, so that a test can tell that it was restored.
volatile std::sig_atomic_t earlier_calls = 0;
void earlier_handler(int /*signal*/) { earlier_calls = earlier_calls + 1; }

/// Installs `earlier_handler` for SIGINT during its lifetime.
class EarlierHandler {
 public:
  EarlierHandler() {
    earlier_calls = 0;
    struct sigaction action {};
    action.sa_handler = earlier_handler;
    ::sigaction(SIGINT, &action, &before_);
  }
  ~EarlierHandler() { ::sigaction(SIGINT, &before_, nullptr); }
  EarlierHandler(const EarlierHandler&) = delete;
  EarlierHandler& operator=(const EarlierHandler&) = delete;

 private:
  struct sigaction before_ {};
};

TEST(Interrupt, TurnsCtrlCIntoAStopAndPutsBackWhatWasThereBefore) {
  const EarlierHandler earlier;
  {
    const Interrupt interrupt;
    EXPECT_FALSE(interrupt.asked());
    std::binary_semaphore stopped(0);
    const std::stop_callback told(interrupt.token(), [&] { stopped.release(); });
    std::raise(SIGINT);
    stopped.acquire();
    EXPECT_TRUE(interrupt.asked());
    EXPECT_EQ(earlier_calls, 0);
  }
  std::raise(SIGINT);
  EXPECT_EQ(earlier_calls, 1);
}

TEST(Interrupt, WithoutCtrlCNothingIsAskedAndANewOneStartsAfresh) {
  const EarlierHandler earlier;
  for (int i = 0; i < 20; ++i) {
    const Interrupt interrupt;
    EXPECT_FALSE(interrupt.asked());
    EXPECT_TRUE(interrupt.token().stop_possible());
  }
  std::raise(SIGINT);
  EXPECT_EQ(earlier_calls, 1);
}

TEST(InterruptDeathTest, ASecondCtrlCEndsTheProcess) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        std::signal(SIGINT, SIG_DFL);
        const Interrupt interrupt;
        std::raise(SIGINT);
        std::raise(SIGINT);
      },
      testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace poise::parallel
