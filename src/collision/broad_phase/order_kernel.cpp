// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/broad_phase/order_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include "collision/broad_phase/order_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace poise::collision::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Few are sorted by counting for each how many are less, side by side: which of two is less no processor foresees,
// and a comparison sort branches upon it.
HWY_INLINE void order_few(std::uint32_t low, const std::uint32_t* high, std::uint32_t count, CandidatePair* pairs) {
  const hn::CappedTag<std::uint32_t, PartnerLists::kPast> d;
  alignas(64) std::uint32_t rank[kLongestOrdered];
  for (std::uint32_t k = 0; k < count; k += static_cast<std::uint32_t>(hn::Lanes(d))) {
    const auto own = hn::LoadU(d, high + k);
    auto less = hn::Zero(d);
    for (std::uint32_t other = 0; other < count; ++other)
      less = hn::Sub(less, hn::VecFromMask(d, hn::Lt(hn::Set(d, high[other]), own)));
    hn::Store(less, d, rank + k);
  }
  for (std::uint32_t k = 0; k < count; ++k) pairs[rank[k]] = {low, high[k]};
}

bool order_lists(const PartnerLists& lists, CandidatePair* pairs) {
  std::uint32_t begin = lists.begin;
  std::uint32_t low = lists.low;
  bool all = true;
  for (const std::uint32_t end : lists.ends) {
    if (end - begin <= kLongestOrdered) {
      order_few(low, lists.high + begin, end - begin, pairs + begin);
    } else {
      all = false;
    }
    begin = end;
    ++low;
  }
  return all;
}

}  // namespace poise::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::collision {

HWY_EXPORT(order_lists);

bool order_partners(const PartnerLists& lists, CandidatePair* pairs) {
  return HWY_DYNAMIC_DISPATCH(order_lists)(lists, pairs);
}

}  // namespace poise::collision
#endif
