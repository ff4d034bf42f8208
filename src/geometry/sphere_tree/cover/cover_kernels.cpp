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

// With the two last squares added first, as Eigen adds those of a vector of three.
float largest(const PointList& points, std::size_t first, std::size_t last, const float* c) {
  const hn::CappedTag<float, kReadBeyond> d;
  const auto cx = hn::Set(d, c[0]);
  const auto cy = hn::Set(d, c[1]);
  const auto cz = hn::Set(d, c[2]);
  auto most = hn::Zero(d);
  for (std::size_t i = first; i < last; i += hn::Lanes(d)) {
    const auto dx = hn::Sub(hn::LoadU(d, points.x.data() + i), cx);
    const auto dy = hn::Sub(hn::LoadU(d, points.y.data() + i), cy);
    const auto dz = hn::Sub(hn::LoadU(d, points.z.data() + i), cz);
    const auto square = hn::Add(hn::Mul(dx, dx), hn::Add(hn::Mul(dy, dy), hn::Mul(dz, dz)));
    most = hn::Max(most, hn::IfThenElseZero(hn::FirstN(d, last - i), square));
  }
  return hn::GetLane(hn::MaxOfLanes(d, most));
}

std::size_t between(const PointList& points, std::uint32_t first, std::uint32_t last, const DistanceRange& range,
                    const std::uint32_t* count, std::uint32_t* out) {
  const hn::CappedTag<float, kReadBeyond> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto cx = hn::Set(d, range.center.x());
  const auto cy = hn::Set(d, range.center.y());
  const auto cz = hn::Set(d, range.center.z());
  const auto least = hn::Set(d, range.least);
  const auto most = hn::Set(d, range.most);
  const std::size_t lanes = hn::Lanes(d);
  std::size_t found = 0;
  auto index = hn::Iota(du, first);
  for (std::size_t i = first; i < last; i += lanes) {
    const auto square = squares(d, points, i, cx, cy, cz);
    auto in = hn::And(hn::Ge(square, least), hn::Le(square, most));
    in = hn::And(in, hn::FirstN(d, last - i));
    auto taken = hn::RebindMask(du, in);
    if (count != nullptr) taken = hn::And(taken, hn::Eq(hn::LoadU(du, count + i), hn::Zero(du)));
    found += hn::CompressStore(index, taken, du, out + found);
    index = hn::Add(index, hn::Set(du, static_cast<std::uint32_t>(lanes)));
  }
  return found;
}

std::size_t beyond(const float* squared_distance, const float* reach, std::size_t count, float radius,
                   std::uint32_t* out) {
  const hn::CappedTag<float, kReadBeyond> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto limit = hn::Set(d, radius);
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto far = hn::Add(hn::Sqrt(hn::LoadU(d, squared_distance + i)), hn::LoadU(d, reach + i));
    const auto in = hn::And(hn::Gt(far, limit), hn::FirstN(d, count - i));
    found += hn::CompressStore(hn::Iota(du, static_cast<std::uint32_t>(i)), hn::RebindMask(du, in), du, out + found);
  }
  return found;
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
HWY_EXPORT(largest);
HWY_EXPORT(between);
HWY_EXPORT(beyond);
HWY_EXPORT(weight);
HWY_EXPORT(weight_of_balls);

float squared_distances(const PointList& points, const Vec3f& center, float* out) {
  return HWY_DYNAMIC_DISPATCH(distances)(points, center.data(), out);
}

float largest_squared_distance(const PointList& points, std::size_t first, std::size_t last, const Vec3f& center) {
  return HWY_DYNAMIC_DISPATCH(largest)(points, first, last, center.data());
}

std::size_t points_between(const PointList& points, std::uint32_t first, std::uint32_t last, const DistanceRange& range,
                           const std::uint32_t* count, std::uint32_t* out) {
  return HWY_DYNAMIC_DISPATCH(between)(points, first, last, range, count, out);
}

std::size_t balls_beyond(const float* squared_distance, const float* reach, std::size_t count, float radius,
                         std::uint32_t* out) {
  return HWY_DYNAMIC_DISPATCH(beyond)(squared_distance, reach, count, radius, out);
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
