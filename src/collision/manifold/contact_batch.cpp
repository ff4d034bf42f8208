// SPDX-License-Identifier: MIT
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/manifold/contact_batch.cpp"
#include <hwy/foreach_target.h>
// Highway compiles this file once for each instruction set, so it comes after foreach_target.
#include <hwy/highway.h>

#include <algorithm>

#include "collision/manifold/contact_batch.h"
#include "collision/manifold/contact_sums.h"
#include "poise_assert.h"

HWY_BEFORE_NAMESPACE();
namespace poise::collision::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kMostLanes = 8;

// Nodes of one side, gathered from the arrays of a tree.
struct Nodes {
  alignas(64) float x[ContactBatch::kEntries], y[ContactBatch::kEntries], z[ContactBatch::kEntries];
  alignas(64) float radius[ContactBatch::kEntries], mean[ContactBatch::kEntries], most[ContactBatch::kEntries];
};

template <NodeIndex FrontEntry::*kSide>
HWY_INLINE void gather(const SphereTree& tree, std::span<const FrontEntry> entries, std::size_t padded, Nodes& nodes) {
  for (std::size_t k = 0; k < padded; ++k) {
    const NodeIndex node = entries[std::min(k, entries.size() - 1)].*kSide;
    nodes.x[k] = tree.x_m[node];
    nodes.y[k] = tree.y_m[node];
    nodes.z[k] = tree.z_m[node];
    nodes.radius[k] = tree.radius_m[node];
    nodes.mean[k] = tree.protrusion_mean_m[node];
    nodes.most[k] = tree.protrusion_max_m[node];
  }
}

// False when some centres coincide.
bool contacts(const PairFrame& frame, std::span<const FrontEntry> entries, ContactBatch& batch) {
  const hn::CappedTag<double, kMostLanes> d;
  const hn::Rebind<float, decltype(d)> narrow;
  const std::size_t padded = (entries.size() + kMostLanes - 1) / kMostLanes * kMostLanes;
  Nodes a;
  Nodes b;
  gather<&FrontEntry::a>(frame.a->tree, entries, padded, a);
  gather<&FrontEntry::b>(frame.b->tree, entries, padded, b);
  bool sound = true;
  for (std::size_t k = 0; k < padded; k += hn::Lanes(d)) {
    const auto wide = [&](const float* from) HWY_ATTR { return hn::PromoteTo(d, hn::Load(narrow, from + k)); };
    const auto ax = wide(a.x);
    const auto ay = wide(a.y);
    const auto az = wide(a.z);
    const auto bx = wide(b.x);
    const auto by = wide(b.y);
    const auto bz = wide(b.z);
    const auto product = [&](int row, int column, auto value)
                             HWY_ATTR { return hn::Mul(hn::Set(d, frame.rotation(row, column)), value); };
    // The sums run in the order that Eigen's 3 x 3 product and norm have in sphere_contact; a test compares the bits.
    const auto moved_x = hn::Add(hn::Add(product(0, 0, bx), product(0, 1, by)), product(0, 2, bz));
    const auto moved_y = hn::Add(hn::Add(product(1, 0, bx), product(1, 1, by)), product(1, 2, bz));
    const auto moved_z = hn::Add(product(2, 0, bx), hn::Add(product(2, 1, by), product(2, 2, bz)));
    const auto dx = hn::Sub(hn::Add(moved_x, hn::Set(d, frame.offset_m.x())), ax);
    const auto dy = hn::Sub(hn::Add(moved_y, hn::Set(d, frame.offset_m.y())), ay);
    const auto dz = hn::Sub(hn::Add(moved_z, hn::Set(d, frame.offset_m.z())), az);
    const auto distance = hn::Sqrt(hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz)));
    const auto radius = wide(a.radius);
    const auto reach = hn::Add(radius, wide(b.radius));
    sound = sound && hn::AllTrue(d, hn::Gt(distance, hn::Mul(hn::Set(d, kCoinciding), reach)));
    const auto share = hn::Div(radius, reach);
    hn::Store(hn::Div(dx, distance), d, batch.normal.x + k);
    hn::Store(hn::Div(dy, distance), d, batch.normal.y + k);
    hn::Store(hn::Div(dz, distance), d, batch.normal.z + k);
    hn::Store(hn::Add(hn::Mul(dx, share), ax), d, batch.point_m.x + k);
    hn::Store(hn::Add(hn::Mul(dy, share), ay), d, batch.point_m.y + k);
    hn::Store(hn::Add(hn::Mul(dz, share), az), d, batch.point_m.z + k);
    hn::Store(hn::Sub(distance, reach), d, batch.gap_m + k);
    hn::Store(hn::Add(wide(a.mean), wide(b.mean)), d, batch.expected_m + k);
    hn::Store(hn::Add(wide(a.most), wide(b.most)), d, batch.certain_m + k);
  }
  return sound;
}

// With w = 0 the products are zeros, and a sum to which zeros are added keeps its bits.
void wrenches(double limit, double margin, ContactBatch& batch) {
  const hn::CappedTag<double, kMostLanes> d;
  const auto zero = hn::Zero(d);
  for (std::size_t k = 0; k < batch.count; k += hn::Lanes(d)) {
    const auto at = [&](const double* from) HWY_ATTR { return hn::Load(d, from + k); };
    const auto gap = at(batch.gap_m);
    const auto nearer = hn::And(hn::Lt(gap, hn::Set(d, limit)), hn::Lt(gap, hn::Set(d, margin)));
    const auto weight = hn::IfThenElse(nearer, hn::Sub(hn::Set(d, limit), gap), zero);
    const auto nx = hn::Mul(weight, at(batch.normal.x));
    const auto ny = hn::Mul(weight, at(batch.normal.y));
    const auto nz = hn::Mul(weight, at(batch.normal.z));
    const auto px = at(batch.point_m.x);
    const auto py = at(batch.point_m.y);
    const auto pz = at(batch.point_m.z);
    hn::Store(weight, d, batch.weight_m + k);
    hn::Store(nx, d, batch.direction.x + k);
    hn::Store(ny, d, batch.direction.y + k);
    hn::Store(nz, d, batch.direction.z + k);
    hn::Store(hn::Sub(hn::Mul(py, nz), hn::Mul(pz, ny)), d, batch.moment_m2.x + k);
    hn::Store(hn::Sub(hn::Mul(pz, nx), hn::Mul(px, nz)), d, batch.moment_m2.y + k);
    hn::Store(hn::Sub(hn::Mul(px, ny), hn::Mul(py, nx)), d, batch.moment_m2.z + k);
    hn::Store(hn::Mul(weight, px), d, batch.place_m2.x + k);
    hn::Store(hn::Mul(weight, py), d, batch.place_m2.y + k);
    hn::Store(hn::Mul(weight, pz), d, batch.place_m2.z + k);
  }
}

}  // namespace poise::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace poise::collision {

HWY_EXPORT(contacts);
HWY_EXPORT(wrenches);

void set_contacts(const PairFrame& frame, std::span<const FrontEntry> entries, ContactBatch& batch) {
  POISE_ASSERT(!entries.empty() && entries.size() <= ContactBatch::kEntries && !frame.with_plane());
  batch.count = entries.size();
  if (HWY_DYNAMIC_DISPATCH(contacts)(frame, entries, batch)) return;
  // Coinciding centres need a fallback direction: rare, so sphere_contact does it.
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const SphereContact contact = sphere_contact(frame, entries[k]);
    const auto put = [k](const Vec3& v, ContactBatch::Vectors& into) {
      into.x[k] = v.x();
      into.y[k] = v.y();
      into.z[k] = v.z();
    };
    put(contact.normal, batch.normal);
    put(contact.point_m, batch.point_m);
    batch.gap_m[k] = contact.gap_m;
  }
}

void set_wrenches(double limit_m, double margin_m, ContactBatch& batch) {
  HWY_DYNAMIC_DISPATCH(wrenches)(limit_m, margin_m, batch);
}

}  // namespace poise::collision
#endif
