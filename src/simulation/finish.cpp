// SPDX-License-Identifier: MIT
#include <algorithm>

#include "dynamics/rotation.h"
#include "simulation/stages.h"
#include "simulation/swept.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kGrain = 128;

void integrate_body(WorldState& world, std::size_t i, double h_s) {
  dynamics::BodyStore& bodies = world.bodies;
  const response::SolverBody& solved = world.buffers.solver_bodies[i];
  const response::Acceleration& pull = world.buffers.accelerations[i];
  // A body that no resting contact held flies on a parabola, exactly: h (v+ + v_next) / 2.
  const Vec3 moved = solved.answered
                         ? solved.moved_m
                         : Vec3(h_s * solved.velocity_mps - (0.5 * h_s * h_s) * pull.linear_mps2);
  bodies.set_position(i, bodies.position(i) + moved);
  bodies.set_velocity(i, solved.velocity_mps);
  const Quat before = bodies.orientation(i);
  const Quat& axes = bodies.shape[i]->principal_axes;
  dynamics::Rotation rotation{bodies.orientation(i) * axes, solved.spin_radps};
  rotation = dynamics::turned_freely(rotation, bodies.principal_kgm2[i], h_s);
  if (solved.answered) {
    // What contacts turned the body beyond its spin, as where they pushed it out of an overlap. Its angular momentum stays.
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
Contact contact_of(const WorldState& world, const ActivePair& pair, const response::ContactRow& row, const Vec3& rest_ns) {
  Contact contact;
  contact.a = world.bodies.id_of(pair.low);
  contact.b = world.bodies.id_of(pair.high);
  contact.level = pair.answered_level();
  const double sign = pair.a == pair.low ? 1.0 : -1.0;
  const response::RestPatch& place = world.buffers.rest_patches[pair.place_begin];
  contact.normal = sign * place.normal;
  contact.point_m = world.buffers.poses[pair.a].position_m + place.arm_m;
  contact.gap_m = row.gap_m;
  contact.impulse_ns = sign * (row.impact_ns() + rest_ns);
  return contact;
}

// What a pair takes along, the motion of this step counted.
PairMemory remembered(const FrameBuffers& buffers, const ActivePair& pair) {
  PairMemory memory = pair.memory;
  memory.frames_waited = pair.answered_level() > 0 || !pair.refinable() ? 0 : memory.frames_waited + 1;
  memory.touching = false;
  memory.place_begin = pair.place_begin;
  memory.place_count = pair.place_count;
  if (pair.fresh()) {
    memory.level = pair.level.level;
    memory.apart = pair.level.apart;
    memory.reach_m = pair.reach_m;
    memory.moved_m = 0;
  } else if (pair.kept == Kept::Nothing) {
    memory.level = 0;
    memory.apart = false;
    memory.reach_m = 0;
  }
  const StepMotion& a = buffers.motions[pair.a];
  const StepMotion& b = buffers.motions[pair.b];
  memory.moved_m += (b.moved_m - a.moved_m).norm() + a.turned_m + b.turned_m;
  return memory;
}

// Pairs that met within the step, put in among the others.
void add_swept_contacts(WorldState& world) {
  const FrameBuffers& buffers = world.buffers;
  if (buffers.swept.hits.empty()) return;
  for (const SweptHit& hit : buffers.swept.hits) {
    const ActivePair& pair = buffers.pairs[hit.pair];
    const double sign = pair.a == pair.low ? 1.0 : -1.0;
    Contact contact;
    contact.a = world.bodies.id_of(pair.low);
    contact.b = world.bodies.id_of(pair.high);
    contact.level = collision::deepest_level(*world.bodies.shape[pair.a], *world.bodies.shape[pair.b], kMaxTreeDepth);
    contact.normal = sign * hit.normal;
    contact.point_m = hit.point_m;
    contact.gap_m = hit.gap_m;
    contact.impulse_ns = hit.impulse_ns * contact.normal;
    world.contacts.push_back(contact);
  }
  std::stable_sort(world.contacts.begin(), world.contacts.end(), [](const Contact& x, const Contact& y) {
    return std::pair(x.a.slot, x.b.slot) < std::pair(y.a.slot, y.b.slot);
  });
  // A pair that touched at the start too is one contact.
  std::size_t kept = 0;
  for (std::size_t k = 1; k < world.contacts.size(); ++k) {
    if (world.contacts[k].a == world.contacts[kept].a && world.contacts[k].b == world.contacts[kept].b) {
      world.contacts[kept].impulse_ns += world.contacts[k].impulse_ns;
    } else {
      world.contacts[++kept] = world.contacts[k];
    }
  }
  world.contacts.resize(kept + 1);
}

// Merges the touching pairs of two frames, both sorted, into what began and what ended.
void make_events(WorldState& world) {
  const auto event = [&](ContactEvent::Kind kind, const PairMemory& pair) {
    world.events.push_back({kind, world.bodies.id_of(pair.low), world.bodies.id_of(pair.high)});
  };
  const auto key = [](const PairMemory& pair) { return std::pair(pair.low, pair.high); };
  auto before = world.memory.begin();
  auto after = world.next_memory.begin();
  while (before != world.memory.end() || after != world.next_memory.end()) {
    if (after == world.next_memory.end() || (before != world.memory.end() && key(*before) < key(*after))) {
      if (before->touching) event(ContactEvent::Kind::End, *before);
      ++before;
    } else if (before == world.memory.end() || key(*after) < key(*before)) {
      if (after->touching) event(ContactEvent::Kind::Begin, *after);
      ++after;
    } else {
      if (before->touching != after->touching) {
        event(after->touching ? ContactEvent::Kind::Begin : ContactEvent::Kind::End, *after);
      }
      ++before;
      ++after;
    }
  }
}

}  // namespace

void integrate(WorldState& world, const StepInput& input) {
  world.buffers.motions.assign(world.bodies.slot_count(), StepMotion{});
  parallel::parallel_for(*world.executor, world.bodies.slot_count(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (world.bodies.dynamic[i] == 0) continue;
      if (input.backtracking && place_stopped(world, static_cast<std::uint32_t>(i))) continue;
      integrate_body(world, i, input.dt_s);
    }
  });
}

void publish(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  world.next_memory.clear();
  // Both, since they change places: a later frame must find the room that this one needed.
  world.memory.reserve(buffers.pairs.capacity());
  world.next_memory.reserve(buffers.pairs.capacity());
  world.places.reserve(buffers.places.capacity());
  buffers.places.reserve(world.places.capacity());
  world.events.reserve(world.memory.capacity() + world.next_memory.capacity());
  world.next_memory.resize(buffers.pairs.size());
  keep_impulses(world);
  parallel::parallel_for(*world.executor, buffers.pairs.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) world.next_memory[i] = remembered(buffers, buffers.pairs[i]);
  });
  parallel::parallel_for(*world.executor, buffers.rows.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const response::ContactRow& row = buffers.rows[k];
      world.next_memory[row.pair].touching =
          row.gap_m <= 0 || row.total_ns > 0 || !row.point_impulse_ns.isZero(0) || !buffers.rest_pairs[k].impulse_ns.isZero(0);
    }
  });
  for (const SweptHit& hit : buffers.swept.hits) world.next_memory[hit.pair].touching = true;
  std::swap(world.places, buffers.places);
  world.contacts_listed = false;
  world.events.clear();
  make_events(world);
  std::swap(world.memory, world.next_memory);
}

void list_contacts(WorldState& world) {
  const FrameBuffers& buffers = world.buffers;
  world.contacts.resize(buffers.rows.size());
  for (std::size_t k = 0; k < buffers.rows.size(); ++k) {
    const response::ContactRow& row = buffers.rows[k];
    world.contacts[buffers.coloring.order()[k]] = contact_of(world, buffers.pairs[row.pair], row, buffers.rest_pairs[k].impulse_ns);
  }
  add_swept_contacts(world);
  world.contacts_listed = true;
}

}  // namespace poise::simulation
