// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <tuple>

#include "dynamics/rotation.h"
#include "frame/ccd/swept.h"
#include "frame/contact_points.h"
#include "frame/kinematic.h"
#include "frame/stages.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kPublishGrain = 128;

void integrate_body(WorldState& world, std::size_t i, double h_s) {
  dynamics::BodyStore& bodies = world.bodies;
  const solver::SolverBody& solved = world.buffers.solver_bodies[i];
  const solver::Acceleration& pull = world.buffers.accelerations[i];
  // A body that no resting contact held flies on a parabola, exactly: h (v+ + v_next) / 2.
  const Vec3 moved =
      solved.solved ? solved.moved_m : Vec3(h_s * solved.velocity_mps - (0.5 * h_s * h_s) * pull.linear_mps2);
  bodies.set_position(i, bodies.position(i) + moved);
  bodies.set_velocity(i, solved.velocity_mps);
  const Quat before = bodies.orientation(i);
  const Quat& axes = bodies.shape[i]->principal_axes;
  dynamics::Rotation rotation{bodies.orientation(i) * axes, solved.spin_radps};
  rotation = dynamics::turned_freely(rotation, bodies.principal_kgm2[i], h_s);
  if (solved.solved) {
    // What contacts turned the body beyond its spin, as where they pushed it out of an overlap. Its angular momentum
    // stays.
    const Quat turn = dynamics::rotation_by(solved.turned_rad - h_s * solved.spin_radps);
    rotation = dynamics::turned_by(rotation, bodies.principal_kgm2[i], turn);
  }
  bodies.set_orientation(i, (rotation.orientation * axes.conjugate()).normalized());
  bodies.set_spin(i, rotation.spin_radps);
  // A point of the surface moves along a chord of its turn.
  const double sine = (bodies.orientation(i) * before.conjugate()).vec().norm();
  world.buffers.motions[i] = {moved, 2.0 * bodies.shape[i]->bounding_radius_m * sine};
  if (bodies.pushed[i] != 0) {
    bodies.set_force(i, Vec3::Zero());
    bodies.set_torque(i, Vec3::Zero());
    bodies.pushed[i] = 0;
  }
}

// What an answered pair tells the caller. The plane of a pair stands second in the row, whatever its slot.
Contact contact_of(const WorldState& world, std::uint32_t index, const solver::ContactRow* row, const Vec3& rest_ns) {
  const ActivePair& pair = world.buffers.pairs[index];
  Contact contact;
  contact.a = world.bodies.id_of(pair.low());
  contact.b = world.bodies.id_of(pair.high());
  contact.level = pair.solved_level();
  const double sign = pair.a == pair.low() ? 1.0 : -1.0;
  const solver::PlacedPoint place = impact_point_of(world, pair);
  contact.normal = sign * place.normal;
  contact.point_m = world.buffers.poses[pair.a].position_m + place.arm_m;
  contact.gap_m = solved_gap_m(world, index);
  contact.impulse_ns = sign * rest_ns;
  if (row != nullptr) contact.impulse_ns += sign * row->impact_ns();
  list_points(world, pair, sign, contact);
  return contact;
}

// What the body in the lower slot gave the other in the step, by rest and impacts of the k-th row.
Vec3 touch_impulse_ns(const WorldState& world, std::size_t k) {
  const FrameBuffers& buffers = world.buffers;
  const std::uint32_t place = buffers.coloring.order()[k];
  const ActivePair& pair = buffers.pairs[buffers.manifolds[place].pair];
  Vec3 given_ns = buffers.applied_impulse_ns[place];
  if (const solver::ContactRow* row = row_of(buffers, k)) given_ns += row->impact_ns();
  return pair.a == pair.low() ? given_ns : Vec3(-given_ns);
}

// What a pair takes along, the motion of this step counted.
CachedPair remembered(const FrameBuffers& buffers, const ActivePair& pair) {
  CachedPair memory = pair.memory;
  memory.frames_waited = pair.solved_level() > 0 || !pair.refinable() ? 0 : memory.frames_waited + 1;
  memory.touching = false;
  memory.solved = pair.solved;
  memory.point_count = pair.point_count;
  if (pair.fresh()) {
    memory.level = pair.level.level;
    memory.apart = pair.level.apart;
    memory.reach_m = pair.reach_m;
    if (pair.level.apart && pair.level.front_entries == 0 && !pair.level.nearly && !pair.exact)
      memory.reach_m += wide_m(pair);
    memory.moved_m = 0;
  } else if (pair.cached == CacheUse::None) {
    // The one place of level 0 is kept like others; that nothing is answered there is no knowledge.
    const bool holds = pair.point_count > 0 && !pair.exact && pair.reach_m > pair.margin_m;
    memory.level = 0;
    memory.apart = false;
    memory.reach_m = holds ? pair.reach_m : 0;
    memory.moved_m = 0;
  }
  const StepMotion& a = buffers.motions[pair.a];
  const StepMotion& b = buffers.motions[pair.b];
  memory.moved_m += (b.moved_m - a.moved_m).norm() + a.turned_m + b.turned_m;
  return memory;
}

// Was a body of the pair removed since the step?
bool was_removed(const WorldState& world, const ActivePair& pair) {
  return std::any_of(world.removed_bodies.begin(), world.removed_bodies.end(),
                     [&](const BodyId& body) { return body.slot == pair.a || body.slot == pair.b; });
}

// Pairs that met within the step, put in among the others.
void add_swept_contacts(const WorldState& world, std::vector<Contact>& contacts) {
  const FrameBuffers& buffers = world.buffers;
  if (buffers.swept.hits.empty()) return;
  for (const SweptHit& hit : buffers.swept.hits) {
    const ActivePair& pair = buffers.pairs[hit.pair];
    if (was_removed(world, pair)) continue;
    const double sign = pair.a == pair.low() ? 1.0 : -1.0;
    Contact contact;
    contact.a = world.bodies.id_of(pair.low());
    contact.b = world.bodies.id_of(pair.high());
    contact.level = collision::deepest_level(*world.bodies.shape[pair.a], *world.bodies.shape[pair.b], kMaxTreeDepth);
    contact.normal = sign * hit.normal;
    contact.point_m = hit.point_m;
    contact.gap_m = hit.gap_m;
    contact.impulse_ns = hit.impulse_ns * contact.normal;
    contact.point_slots[0] = {contact.point_m, contact.normal, contact.gap_m, contact.impulse_ns};
    contact.point_count = 1;
    contacts.push_back(contact);
  }
  std::stable_sort(contacts.begin(), contacts.end(), [](const Contact& x, const Contact& y) {
    return std::pair(x.a.slot, x.b.slot) < std::pair(y.a.slot, y.b.slot);
  });
  if (contacts.empty()) return;
  // A pair that touched at the start too is one contact.
  std::size_t cached = 0;
  for (std::size_t k = 1; k < contacts.size(); ++k) {
    if (contacts[k].a == contacts[cached].a && contacts[k].b == contacts[cached].b) {
      contacts[cached].impulse_ns += contacts[k].impulse_ns;
      merge_points(contacts[k], contacts[cached]);
    } else {
      contacts[++cached] = contacts[k];
    }
  }
  contacts.resize(cached + 1);
}

// What of the last frame's pairs is none of this frame's: a touch ends, and its room is free.
void forget_parted(WorldState& world) {
  const std::vector<std::uint8_t>& recalled = world.buffers.recalled;
  for (auto at = recalled.begin(); (at = std::find(at, recalled.end(), std::uint8_t{0})) != recalled.end(); ++at) {
    const CachedPair& pair = world.memory[static_cast<std::size_t>(at - recalled.begin())];
    world.points.give_back(pair.room);
    if (pair.touching)
      world.events.push_back({ContactEvent::Kind::End, world.bodies.id_of(pair.low), world.bodies.id_of(pair.high)});
  }
}

// Touches that began or ended since the last frame, in canonical order.
void make_events(WorldState& world, bool persist) {
  const FrameBuffers& buffers = world.buffers;
  forget_parted(world);
  world.events.insert(world.events.end(), world.removal_events.begin(), world.removal_events.end());
  world.removal_events.clear();
  const std::size_t parted = world.events.size();
  const std::vector<std::uint8_t>& turned = buffers.turned;
  for (auto at = turned.begin(); (at = std::find(at, turned.end(), std::uint8_t{1})) != turned.end(); ++at) {
    const CachedPair& pair = world.next_memory[static_cast<std::size_t>(at - turned.begin())];
    const bool begins = pair.touching;
    world.events.push_back({begins ? ContactEvent::Kind::Begin : ContactEvent::Kind::End, world.bodies.id_of(pair.low),
                            world.bodies.id_of(pair.high),
                            begins ? buffers.touch_ns[static_cast<std::size_t>(at - turned.begin())] : Vec3::Zero()});
  }
  if (persist) {
    for (std::size_t i = 0; i < turned.size(); ++i) {
      const CachedPair& pair = world.next_memory[i];
      if (turned[i] != 0 || !pair.touching) continue;
      world.events.push_back({ContactEvent::Kind::Persist, world.bodies.id_of(pair.low), world.bodies.id_of(pair.high),
                              buffers.touch_ns[i]});
    }
  }
  if (parted == 0 && !persist) return;
  // A pair has one event at most; of two in the same slots, the bodies that were removed come first.
  std::sort(world.events.begin(), world.events.end(), [](const ContactEvent& x, const ContactEvent& y) {
    return std::tuple(x.a.slot, x.b.slot, x.a.generation, x.b.generation) <
           std::tuple(y.a.slot, y.b.slot, y.a.generation, y.b.generation);
  });
}

// Does the pair of the k-th row touch? Impulses make a touch of what is apart.
bool touches(const WorldState& world, std::size_t k) {
  const FrameBuffers& buffers = world.buffers;
  const std::uint32_t place = buffers.coloring.order()[k];
  if (!buffers.applied_impulse_ns[place].isZero(0)) return true;
  const solver::ContactRow* row = row_of(buffers, k);
  if (row != nullptr && (row->total_ns > 0 || !row->point_impulse_ns.isZero(0))) return true;
  const std::uint32_t index = buffers.manifolds[place].pair;
  const ActivePair& pair = buffers.pairs[index];
  if (pair.from_cache() && std::abs(pair.memory.impact_gap_m) > pair.memory.changed_m())
    return pair.memory.impact_gap_m <= 0;
  return solved_gap_m(world, index) <= 0;
}

}  // namespace

void integrate(WorldState& world, const StepInput& input) {
  world.buffers.motions.assign(world.bodies.slot_count(), StepMotion{});
  parallel::parallel_for(*world.executor, world.bodies.slot_count(), kPublishGrain,
                         [&](std::size_t begin, std::size_t end, int) {
                           for (std::size_t i = begin; i < end; ++i) {
                             if (world.bodies.kinematic[i] != 0)
                               world.buffers.motions[i] = move_kinematic(world.bodies, i, input.dt_s);
                             if (world.bodies.dynamic[i] == 0) continue;
                             if (input.backtracking && place_stopped(world, static_cast<std::uint32_t>(i))) continue;
                             integrate_body(world, i, input.dt_s);
                           }
                         });
}

void publish(WorldState& world, const StepInput& input) {
  FrameBuffers& buffers = world.buffers;
  world.next_memory.clear();
  // Both, since they change places: a later frame must find the room that this one needed.
  world.memory.reserve(buffers.pairs.capacity());
  world.next_memory.reserve(buffers.pairs.capacity());
  world.events.reserve(world.memory.capacity() + world.next_memory.capacity());
  world.next_memory.resize(buffers.pairs.size());
  buffers.turned.resize(buffers.pairs.size());
  buffers.touch_ns.reserve(buffers.pairs.capacity());
  buffers.touch_ns.resize(buffers.pairs.size());
  parallel::parallel_for(*world.executor, buffers.pairs.size(), 4 * kPublishGrain,
                         [&](std::size_t begin, std::size_t end, int) {
                           for (std::size_t i = begin; i < end; ++i) {
                             world.next_memory[i] = remembered(buffers, buffers.pairs[i]);
                             buffers.turned[i] = buffers.pairs[i].memory.touching ? 1 : 0;
                           }
                         });
  parallel::parallel_for(*world.executor, buffers.manifolds.size(), 4 * kPublishGrain,
                         [&](std::size_t begin, std::size_t end, int) {
                           for (std::size_t k = begin; k < end; ++k) {
                             if (!touches(world, k)) continue;
                             const std::uint32_t i = buffers.manifolds[buffers.coloring.order()[k]].pair;
                             world.next_memory[i].touching = true;
                             buffers.turned[i] ^= 1U;
                             if (buffers.turned[i] != 0 || input.persist_events)
                               buffers.touch_ns[i] = touch_impulse_ns(world, k);
                           }
                         });
  for (const SweptHit& hit : buffers.swept.hits) {
    bool& touching = world.next_memory[hit.pair].touching;
    const ActivePair& pair = buffers.pairs[hit.pair];
    if (!touching) {
      buffers.turned[hit.pair] ^= 1U;
      buffers.touch_ns[hit.pair].setZero();
    }
    touching = true;
    buffers.touch_ns[hit.pair] += (pair.a == pair.low() ? hit.impulse_ns : -hit.impulse_ns) * hit.normal;
  }
  ++world.contacts_version;
  world.events.clear();
  make_events(world, input.persist_events);
  std::swap(world.memory, world.next_memory);
}

std::vector<Contact> list_contacts(const WorldState& world, ContactListing listing) {
  const FrameBuffers& buffers = world.buffers;
  // The rows stand in the order of the colouring, the contacts in that of the pairs.
  constexpr std::uint32_t kNotListed = 0xffffffffU;
  std::vector<std::uint32_t> row_of_place(buffers.manifolds.size(), kNotListed);
  for (std::uint32_t k = 0; k < buffers.manifolds.size(); ++k) {
    if (listing == ContactListing::Answered || touches(world, k)) row_of_place[buffers.coloring.order()[k]] = k;
  }
  std::vector<Contact> contacts;
  for (std::size_t place = 0; place < row_of_place.size(); ++place) {
    const std::uint32_t pair = buffers.manifolds[place].pair;
    if (row_of_place[place] == kNotListed || was_removed(world, buffers.pairs[pair])) continue;
    contacts.push_back(
        contact_of(world, pair, row_of(buffers, row_of_place[place]), buffers.applied_impulse_ns[place]));
  }
  add_swept_contacts(world, contacts);
  return contacts;
}

}  // namespace poise::simulation
