// SPDX-License-Identifier: MIT
// Vectors of three in the lanes of a register. Read once for each instruction set, by a file that Highway compiles so;
// hence the guard that turns over instead of staying.
#if defined(POISE_GEOMETRY_TRIPLE_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef POISE_GEOMETRY_TRIPLE_LANES_INL_H
#undef POISE_GEOMETRY_TRIPLE_LANES_INL_H
#else
#define POISE_GEOMETRY_TRIPLE_LANES_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace poise::geometry::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Multiplications and additions stay apart: fused ones would round differently from one instruction set to the next.

// Three numbers in each lane.
template <class V>
struct Triple {
  V x, y, z;
};

template <class V>
HWY_INLINE V dot(const Triple<V>& a, const Triple<V>& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <class V>
HWY_INLINE Triple<V> sum(const Triple<V>& a, const Triple<V>& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
template <class V>
HWY_INLINE Triple<V> difference(const Triple<V>& a, const Triple<V>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <class V>
HWY_INLINE Triple<V> scaled(const V& by, const Triple<V>& a) {
  return {hn::Mul(by, a.x), hn::Mul(by, a.y), hn::Mul(by, a.z)};
}
template <class V>
HWY_INLINE Triple<V> cross(const Triple<V>& a, const Triple<V>& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

}  // namespace poise::geometry::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
