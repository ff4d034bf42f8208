// SPDX-License-Identifier: MIT
// A program that uses only the policy: a nearer error is served first.
#include <poise/scheduler/policy.h>

#include <array>

int main() {
  using namespace poise::scheduler;
  const std::array<float, 3> error_m{0.2F, 0.05F, 0.01F};
  PairChain chain;
  chain.error_m = error_m;
  PairCues near_cues, far_cues;
  near_cues.angle_radpm = 1.0;
  far_cues.angle_radpm = 0.1;
  const double near_score = score(Policy{}, FrameFacts{}, chain, near_cues, 0);
  const double far_score = score(Policy{}, FrameFacts{}, chain, far_cues, 1);
  return near_score > far_score && far_score > 0 ? 0 : 1;
}
