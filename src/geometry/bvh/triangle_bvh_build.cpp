// SPDX-License-Identifier: MIT
#include "geometry/bvh/triangle_bvh_build.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace poise::geometry {
namespace {

constexpr std::size_t kBins = 16;
/// Depth below the root from which ranges are halved; 32 more levels halve any mesh down to one triangle.
constexpr int kHalveFrom = 40;

struct SmallBox {
  Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity());
  Eigen::Array3f high = Eigen::Array3f::Constant(-std::numeric_limits<float>::infinity());

  void add(const SmallBox& other) {
    low = low.min(other.low);
    high = high.max(other.high);
  }
  /// Half the surface of the box; 0 for an empty one.
  [[nodiscard]] float half_area() const {
    if (!(low[0] <= high[0])) return 0;
    const Eigen::Array3f size = high - low;
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
  }
};

struct Range {
  std::uint32_t first;
  std::uint32_t count;
  int depth;
  SmallBox box;
};

class Splitter {
 public:
  // Invariant: order is a permutation of the triangles, and splitting a range permutes only its own entries.
  Splitter(std::vector<SmallBox> boxes, std::vector<std::uint32_t>& order) : boxes_(std::move(boxes)), order_(order) {}

  [[nodiscard]] SmallBox box_of(std::uint32_t first, std::uint32_t count) const {
    SmallBox box;
    for (std::uint32_t i = first; i < first + count; ++i) box.add(boxes_[order_[i]]);
    return box;
  }

  /// Splits a range with at least two triangles into two parts that are not empty.
  std::array<Range, 2> split(const Range& range) {
    SmallBox middles;
    for (std::uint32_t i = range.first; i < range.first + range.count; ++i) {
      const Eigen::Array3f middle = middle_of(order_[i]);
      middles.low = middles.low.min(middle);
      middles.high = middles.high.max(middle);
    }
    Eigen::Index axis = 0;
    const float extent = (middles.high - middles.low).maxCoeff(&axis);
    std::uint32_t left = 0;
    if (range.depth < kHalveFrom && range.count > 2 && extent > 0)
      left = split_in_bins(range, axis, middles.low[axis], extent);
    if (left == 0 || left == range.count) left = halve(range, axis);
    const std::uint32_t right = range.count - left;
    return {Range{range.first, left, range.depth + 1, box_of(range.first, left)},
            Range{range.first + left, right, range.depth + 1, box_of(range.first + left, right)}};
  }

 private:
  [[nodiscard]] Eigen::Array3f middle_of(std::uint32_t triangle) const {
    return boxes_[triangle].low + boxes_[triangle].high;
  }

  std::uint32_t halve(const Range& range, Eigen::Index axis) {
    const auto begin = order_.begin() + range.first;
    std::nth_element(begin, begin + range.count / 2, begin + range.count, [&](std::uint32_t s, std::uint32_t t) {
      const float at_s = middle_of(s)[axis];
      const float at_t = middle_of(t)[axis];
      return at_s != at_t ? at_s < at_t : s < t;
    });
    return range.count / 2;
  }

  /// Number of triangles in the left part; 0 if no plane between bins has triangles on both sides.
  std::uint32_t split_in_bins(const Range& range, Eigen::Index axis, float low, float extent) {
    const float scale = static_cast<float>(kBins) * 0.9999F / extent;
    const auto bin_of = [&](std::uint32_t triangle) {
      return std::min(static_cast<std::size_t>((middle_of(triangle)[axis] - low) * scale), kBins - 1);
    };
    std::array<SmallBox, kBins> boxes;
    std::array<std::uint32_t, kBins> counts{};
    for (std::uint32_t i = range.first; i < range.first + range.count; ++i) {
      const std::size_t bin = bin_of(order_[i]);
      boxes[bin].add(boxes_[order_[i]]);
      ++counts[bin];
    }
    std::array<float, kBins> right_cost{};  // of all bins from this one to the last
    SmallBox box;
    std::uint32_t count = 0;
    for (std::size_t bin = kBins - 1; bin > 0; --bin) {
      box.add(boxes[bin]);
      count += counts[bin];
      right_cost[bin] = box.half_area() * static_cast<float>(count);
    }
    box = {};
    count = 0;
    float least = std::numeric_limits<float>::infinity();
    std::size_t best = 0;
    for (std::size_t bin = 1; bin < kBins; ++bin) {
      box.add(boxes[bin - 1]);
      count += counts[bin - 1];
      const float cost = box.half_area() * static_cast<float>(count) + right_cost[bin];
      if (count > 0 && count < range.count && cost < least) {
        least = cost;
        best = bin;
      }
    }
    if (best == 0) return 0;
    const auto begin = order_.begin() + range.first;
    const auto middle = std::partition(begin, begin + range.count, [&](std::uint32_t t) { return bin_of(t) < best; });
    return static_cast<std::uint32_t>(middle - begin);
  }

  std::vector<SmallBox> boxes_;
  std::vector<std::uint32_t>& order_;
};

std::uint32_t add_node(Splitter& splitter, const Range& range, std::vector<BvhNode>& nodes) {
  std::array<Range, 4> parts{range};
  std::size_t count = 1;
  while (count < 4) {
    // Splits the part with the highest cost next.
    std::size_t widest = count;
    float most = -1;
    for (std::size_t i = 0; i < count; ++i) {
      const float cost = parts[i].box.half_area() * static_cast<float>(parts[i].count);
      if (parts[i].count > 1 && cost > most) {
        most = cost;
        widest = i;
      }
    }
    if (widest == count) break;
    const std::array<Range, 2> halves = splitter.split(parts[widest]);
    for (std::size_t i = count; i > widest + 1; --i) parts[i] = parts[i - 1];
    parts[widest] = halves[0];
    parts[widest + 1] = halves[1];
    ++count;
  }
  const auto index = static_cast<std::uint32_t>(nodes.size());
  nodes.emplace_back();
  for (std::size_t slot = 0; slot < 4; ++slot) {
    const SmallBox box = slot < count ? parts[slot].box : SmallBox{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      nodes[index].low[axis][static_cast<Eigen::Index>(slot)] = box.low[static_cast<Eigen::Index>(axis)];
      nodes[index].high[axis][static_cast<Eigen::Index>(slot)] = box.high[static_cast<Eigen::Index>(axis)];
    }
    std::uint32_t child = BvhNode::kNone;
    if (slot < count)
      child = parts[slot].count == 1 ? parts[slot].first | BvhNode::kTriangle : add_node(splitter, parts[slot], nodes);
    nodes[index].child[slot] = child;
  }
  return index;
}

/// Sums over the triangles of one subtree.
struct Sums {
  Vec3 area_normal = Vec3::Zero();
  Vec3 moment = Vec3::Zero();
  double area = 0;
  std::vector<std::uint32_t> points;
};

Sums sums_of(std::uint32_t child, std::span<const BvhNode> nodes, std::span<const TriangleCorners> corners_m,
             const Vec3& origin_m, std::vector<BvhClusters>& clusters) {
  Sums sums;
  if ((child & BvhNode::kTriangle) != 0) {
    const std::uint32_t place = child & ~BvhNode::kTriangle;
    const TriangleCorners& t = corners_m[place];
    sums.area_normal = 0.5 * (t[1] - t[0]).cross(t[2] - t[0]);
    sums.area = sums.area_normal.norm();
    sums.moment = sums.area * ((t[0] + t[1] + t[2]) / 3 - origin_m);
    sums.points = {place};
    return sums;
  }
  for (std::size_t slot = 0; slot < 4; ++slot) {
    const auto at = static_cast<Eigen::Index>(slot);
    clusters[child].reach2[at] = -1;
    for (std::size_t axis = 0; axis < 3; ++axis)
      clusters[child].middle[axis][at] = clusters[child].area_normal[axis][at] = 0;
    if (nodes[child].child[slot] == BvhNode::kNone) continue;
    const Sums part = sums_of(nodes[child].child[slot], nodes, corners_m, origin_m, clusters);
    const Vec3 first = corners_m[part.points.front()][0] - origin_m;
    const Vec3 middle = part.area > 0 ? Vec3(part.moment / part.area) : first;
    double reach2 = 0;
    for (const std::uint32_t place : part.points) {
      for (const Vec3& corner : corners_m[place]) reach2 = std::max(reach2, (corner - origin_m - middle).squaredNorm());
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      clusters[child].middle[axis][at] = static_cast<float>(middle[static_cast<Eigen::Index>(axis)]);
      clusters[child].area_normal[axis][at] = static_cast<float>(part.area_normal[static_cast<Eigen::Index>(axis)]);
    }
    clusters[child].reach2[at] = static_cast<float>(reach2);
    sums.area_normal += part.area_normal;
    sums.moment += part.moment;
    sums.area += part.area;
    sums.points.insert(sums.points.end(), part.points.begin(), part.points.end());
  }
  return sums;
}

}  // namespace

BvhLayout flatten_bvh(const TriangleMesh& mesh, const Bounds& box) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  const Vec3 origin = box.center();
  // A query point is rounded to single precision too: within two diagonals of the middle, by less than this.
  const auto margin = static_cast<float>(1e-6 * (box.high - box.low).norm());
  std::vector<SmallBox> boxes(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) {
      const Eigen::Array3f corner = (mesh.vertices_m[v] - origin).cast<float>();
      boxes[i].low = boxes[i].low.min(corner);
      boxes[i].high = boxes[i].high.max(corner);
    }
    boxes[i].low -= margin;
    boxes[i].high += margin;
  }
  BvhLayout layout;
  layout.order.resize(count);
  std::iota(layout.order.begin(), layout.order.end(), 0U);
  Splitter splitter(std::move(boxes), layout.order);
  layout.nodes.reserve(count / 2 + 1);
  add_node(splitter, {0, count, 0, splitter.box_of(0, count)}, layout.nodes);
  return layout;
}

std::vector<BvhClusters> clusters_of(std::span<const BvhNode> nodes, std::span<const TriangleCorners> corners_m,
                                     const Vec3& origin_m) {
  std::vector<BvhClusters> clusters(nodes.size());
  if (!nodes.empty()) sums_of(0, nodes, corners_m, origin_m, clusters);
  return clusters;
}

}  // namespace poise::geometry
