// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "parallel/claimed_keys.h"
#include "poise/types.h"

namespace poise::simulation {

/// Cells of space that have bodies in them, one body of each. Which body that is depends on the threads; which cells
/// there are does not. Far from the origin, beyond a million cells, cells may be confused with others.
class OccupiedCells {
 public:
  /// No cells; room for those of so many bodies.
  void begin(std::size_t bodies, parallel::Executor& executor) { slots_.begin(bodies, executor); }
  void reserve(std::size_t bodies) { slots_.reserve(bodies); }
  /// Adds a body to its cell; the body that stands for the cell. Any thread.
  std::uint32_t add(const Vec3& position_m, double cells_per_m, std::uint32_t slot) {
    const Vec3 cell = (position_m * cells_per_m).array().floor();
    return slots_.claim(key_of(static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()),
                               static_cast<std::int64_t>(cell.z())),
                        slot);
  }
  /// Places for cells, used or not.
  [[nodiscard]] std::size_t size() const { return slots_.size(); }
  /// Calls use(own, other) with the bodies that stand for a cell, if there is one, and for each next to it; of two
  /// cells once. Any thread, once all were added.
  template <class Use>
  void for_neighbours(std::size_t place, Use&& use) const {
    const std::uint64_t key = slots_.key_at(place);
    if (key == 0) return;
    for (std::int64_t z = 0; z <= 1; ++z) {
      for (std::int64_t y = z == 0 ? 0 : -1; y <= 1; ++y) {
        for (std::int64_t x = z == 0 && y == 0 ? 1 : -1; x <= 1; ++x) {
          const std::uint32_t other = slots_.value_of(shifted(key, x, y, z));
          if (other != parallel::ClaimedKeys::kNone) use(slots_.value_at(place), other);
        }
      }
    }
  }

 private:
  static constexpr std::uint64_t kMask = (std::uint64_t{1} << 21U) - 1;
  static std::uint64_t key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto part = [](std::int64_t at) { return static_cast<std::uint64_t>(at) & kMask; };
    return std::uint64_t{1} << 63U | part(x) << 42U | part(y) << 21U | part(z);
  }
  static std::uint64_t shifted(std::uint64_t key, std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto part = [&](unsigned bits) { return static_cast<std::int64_t>(key >> bits & kMask); };
    return key_of(part(42) + x, part(21) + y, part(0) + z);
  }

  parallel::ClaimedKeys slots_;
};

}  // namespace poise::simulation
