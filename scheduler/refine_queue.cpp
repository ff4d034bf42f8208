// SPDX-License-Identifier: MIT
#include "poise/scheduler/refine_queue.h"

namespace poise::scheduler {

void RefineQueue::begin_frame(std::uint32_t items, std::int64_t tail_items) {
  if (items > capacity_) {
    capacity_ = items + items / 2;
    open_item_ = std::make_unique<std::atomic<bool>[]>(capacity_);
    units_.resize(capacity_);
  }
  items_ = items;
  for (std::uint32_t item = 0; item < items; ++item) open_item_[item].store(false, std::memory_order_relaxed);
  bands_.reset(items);
  open_.store(0, std::memory_order_relaxed);
  tail_items_.store(tail_items, std::memory_order_relaxed);
  least_units_.store(~std::uint64_t{0}, std::memory_order_relaxed);
}

}  // namespace poise::scheduler
