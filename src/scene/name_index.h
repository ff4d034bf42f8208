// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string_view>
#include <vector>

namespace poise::io {

/// Finds the entries of a list by their `name`, each in time that grows with the logarithm of the list whatever the
/// names are: a hash could be led to collide. Invariant: `order_` has the entries by name. The list outlives it
/// unchanged.
template <class Named>
class NameIndex {
 public:
  explicit NameIndex(const std::vector<Named>& list) : list_(list), order_(list.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    std::sort(order_.begin(), order_.end(),
              [this](std::uint32_t a, std::uint32_t b) { return list_[a].name < list_[b].name; });
  }
  [[nodiscard]] const std::vector<Named>& list() const { return list_; }
  /// Index in the list; none if no entry has this name.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const {
    const auto at = std::lower_bound(order_.begin(), order_.end(), name,
                                     [this](std::uint32_t i, std::string_view other) { return list_[i].name < other; });
    if (at == order_.end() || !(list_[*at].name == name)) return std::nullopt;
    return *at;
  }

 private:
  const std::vector<Named>& list_;
  std::vector<std::uint32_t> order_;
};

}  // namespace poise::io
