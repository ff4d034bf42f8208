// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "geometry/sphere_tree/cover/cover_kernels.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>

#include "geometry/sphere_tree/cover/cover_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace poise::geometry::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Multiplications and additions are separate: fused ones would round differently on different instruction sets. Sums
// are of integers, so their order does not matter.
template <class D>
HWY_INLINE hn::Vec<D> squares(D d, const PointList& points, std::size_t i, const hn::Vec<D>& cx, const hn::Vec<D>& cy,
                              const hn::Vec<D>& cz) {
  const auto dx = hn::Sub(hn::LoadU(d, points.x.data() + i), cx);
  const auto dy = hn::Sub(hn::LoadU(d, points.y.data() + i), cy);
  const auto dz = hn::Sub(hn::LoadU(d, points.z.data() + i), cz);
  return hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
}

float square_of(const PointList& points, std::size_t i, const float* c) {
  const float dx = points.x[i] - c[0];
  const float dy = points.y[i] - c[1];
  const float dz = points.z[i] - c[2];
  return dx * dx + dy * dy + dz * dz;
}

float distances(const PointList& points, const float* c, float* out) {
  const hn::ScalableTag<float> d;
  const std::size_t n = points.size();
  const std::size_t lanes = hn::Lanes(d);
  const auto cx = hn::Set(d, c[0]);
  const auto cy = hn::Set(d, c[1]);
  const auto cz = hn::Set(d, c[2]);
  auto most = hn::Zero(d);
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    const auto square = squares(d, points, i, cx, cy, cz);
    hn::StoreU(square, d, out + i);
    most = hn::Max(most, square);
  }
  float largest = hn::GetLane(hn::MaxOfLanes(d, most));
  for (; i < n; ++i) {
    out[i] = square_of(points, i, c);
    largest = std::max(largest, out[i]);
  }
  return largest;
}

std::int32_t weight(const PointList& points, const std::int32_t* weights, const float* c, float radius) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const std::size_t n = points.size();
  const std::size_t lanes = hn::Lanes(d);
  const auto cx = hn::Set(d, c[0]);
  const auto cy = hn::Set(d, c[1]);
  const auto cz = hn::Set(d, c[2]);
  const auto limit = hn::Set(d, radius * radius);
  auto sum = hn::Zero(di);
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    const auto in = hn::RebindMask(di, hn::Le(squares(d, points, i, cx, cy, cz), limit));
    sum = hn::Add(sum, hn::IfThenElseZero(in, hn::LoadU(di, weights + i)));
  }
  std::int32_t total = hn::GetLane(hn::SumOfLanes(di, sum));
  for (; i < n; ++i) {
    if (square_of(points, i, c) <= radius * radius) total += weights[i];
  }
  return total;
}

std::int32_t weight_of_balls(const PointList& points, const float* reach, const std::int32_t* weights, const float* c,
                             float radius) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const std::size_t n = points.size();
  const std::size_t lanes = hn::Lanes(d);
  const auto cx = hn::Set(d, c[0]);
  const auto cy = hn::Set(d, c[1]);
  const auto cz = hn::Set(d, c[2]);
  const auto whole = hn::Set(d, radius);
  auto sum = hn::Zero(di);
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    const auto left = hn::Sub(whole, hn::LoadU(d, reach + i));
    const auto near = hn::Le(squares(d, points, i, cx, cy, cz), hn::Mul(left, left));
    const auto in = hn::RebindMask(di, hn::And(near, hn::Gt(left, hn::Zero(d))));
    sum = hn::Add(sum, hn::IfThenElseZero(in, hn::LoadU(di, weights + i)));
  }
  std::int32_t total = hn::GetLane(hn::SumOfLanes(di, sum));
  for (; i < n; ++i) {
    const float left = radius - reach[i];
    if (left > 0 && square_of(points, i, c) <= left * left) total += weights[i];
  }
  return total;
}

}  // namespace poise::geometry::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::geometry {

HWY_EXPORT(distances);
HWY_EXPORT(weight);
HWY_EXPORT(weight_of_balls);

float squared_distances(const PointList& points, const Vec3f& center, float* out) {
  return HWY_DYNAMIC_DISPATCH(distances)(points, center.data(), out);
}

std::int32_t weight_within(const PointList& points, const std::vector<std::int32_t>& weights, const Vec3f& center,
                           float radius) {
  return HWY_DYNAMIC_DISPATCH(weight)(points, weights.data(), center.data(), radius);
}

std::int32_t weight_of_balls_within(const PointList& points, const std::vector<float>& reach,
                                    const std::vector<std::int32_t>& weights, const Vec3f& center, float radius) {
  return HWY_DYNAMIC_DISPATCH(weight_of_balls)(points, reach.data(), weights.data(), center.data(), radius);
}

}  // namespace poise::geometry
#endif
