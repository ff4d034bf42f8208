// SPDX-License-Identifier: MIT
#include "parallel/interrupt.h"

#include <gtest/gtest.h>

#include <csignal>
#include <semaphore>

namespace poise::parallel {
namespace {

// Counts calls of the previous handler, so that a test can tell that it was restored.
volatile std::sig_atomic_t earlier_calls = 0;
void earlier_handler(int /*signal*/) { earlier_calls = earlier_calls + 1; }

/// Installs `earlier_handler` for a signal during its lifetime.
class EarlierHandler {
 public:
  explicit EarlierHandler(int signal) : signal_(signal) {
    earlier_calls = 0;
    struct sigaction action {};
    action.sa_handler = earlier_handler;
    ::sigaction(signal_, &action, &before_);
  }
  ~EarlierHandler() { ::sigaction(signal_, &before_, nullptr); }
  EarlierHandler(const EarlierHandler&) = delete;
  EarlierHandler& operator=(const EarlierHandler&) = delete;

 private:
  int signal_;
  struct sigaction before_ {};
};

TEST(Interrupt, TurnsCtrlCAndSigtermIntoAStopAndPutsBackWhatWasThereBefore) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const EarlierHandler earlier(signal);
    {
      const Interrupt interrupt;
      EXPECT_FALSE(interrupt.asked());
      std::binary_semaphore stopped(0);
      const std::stop_callback told(interrupt.token(), [&] { stopped.release(); });
      std::raise(signal);
      EXPECT_TRUE(interrupt.asked()) << "from the signal on";
      stopped.acquire();
      EXPECT_EQ(earlier_calls, 0);
    }
    EXPECT_EQ(stop_signal(), signal);
    EXPECT_STREQ(stop_name(), signal == SIGINT ? "Ctrl-C" : "SIGTERM");
    std::raise(signal);
    EXPECT_EQ(earlier_calls, 1);
  }
}

TEST(Interrupt, WithoutCtrlCNothingIsAskedAndANewOneStartsAfresh) {
  const EarlierHandler earlier(SIGINT);
  for (int i = 0; i < 20; ++i) {
    const Interrupt interrupt;
    EXPECT_FALSE(interrupt.asked());
    EXPECT_TRUE(interrupt.token().stop_possible());
  }
  std::raise(SIGINT);
  EXPECT_EQ(earlier_calls, 1);
}

TEST(InterruptDeathTest, ASecondSignalEndsTheProcessWhicheverItIs) {
  for (const int first : {SIGINT, SIGTERM}) {
    for (const int second : {SIGINT, SIGTERM}) {
      EXPECT_EXIT(
          {
            std::signal(SIGINT, SIG_DFL);
            std::signal(SIGTERM, SIG_DFL);
            const Interrupt interrupt;
            std::raise(first);
            std::raise(second);
          },
          testing::KilledBySignal(second), "");
    }
  }
}

}  // namespace
}  // namespace poise::parallel
