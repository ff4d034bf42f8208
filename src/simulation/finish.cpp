// SPDX-License-Identifier: MIT
#include "dynamics/rotation.h"
#include "simulation/stages.h"

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
  const Quat& axes = bodies.shape[i]->principal_axes;
  dynamics::Rotation rotation{bodies.orientation(i) * axes, solved.spin_radps};
  rotation = dynamics::turned_freely(rotation, bodies.principal_kgm2[i], h_s);
  if (solved.answered) {
    // What contacts turned the body beyond its spin: they push overlapping bodies apart.
    rotation.orientation = dynamics::rotation_by(solved.turned_rad - h_s * solved.spin_radps) * rotation.orientation;
  }
  bodies.set_orientation(i, (rotation.orientation * axes.conjugate()).normalized());
  bodies.set_spin(i, rotation.spin_radps);
  if (bodies.pushed[i] != 0) {
    bodies.set_force(i, Vec3::Zero());
    bodies.set_torque(i, Vec3::Zero());
    bodies.pushed[i] = 0;
  }
}

// What an answered pair tells the caller. The plane of a pair stands second in the row, whatever its slot.
Contact contact_of(const WorldState& world, const ActivePair& pair, const response::ContactRow& row) {
  Contact contact;
  contact.a = world.bodies.id_of(pair.low);
  contact.b = world.bodies.id_of(pair.high);
  contact.level = pair.level.level;
  const double sign = pair.a == pair.low ? 1.0 : -1.0;
  const double length = row.direction.norm();
  if (length > 0) contact.normal = (sign / length) * row.direction;
  contact.point_m = world.buffers.poses[pair.a].position_m + pair.level.contact.arm_m;
  contact.gap_m = row.gap_m;
  contact.impulse_ns = sign * (row.total_ns * row.direction + row.point_impulse_ns);
  return contact;
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
  parallel::parallel_for(*world.executor, world.bodies.slot_count(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (world.bodies.dynamic[i] != 0) integrate_body(world, i, input.dt_s);
    }
  });
}

void publish(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  world.next_memory.clear();
  // Both, since they change places: a later frame must find the room that this one needed.
  world.memory.reserve(buffers.pairs.capacity());
  world.next_memory.reserve(buffers.pairs.capacity());
  world.events.reserve(world.memory.capacity() + world.next_memory.capacity());
  world.next_memory.resize(buffers.pairs.size());
  parallel::parallel_for(*world.executor, buffers.pairs.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const ActivePair& pair = buffers.pairs[i];
      PairMemory& memory = world.next_memory[i];
      memory = pair.memory;
      memory.frames_waited = pair.level.level > 0 || !pair.level.refinable() ? 0 : memory.frames_waited + 1;
      memory.touching = false;
      memory.impulse_ns = 0;
    }
  });
  parallel::parallel_for(*world.executor, buffers.rows.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const response::ContactRow& row = buffers.rows[k];
      PairMemory& memory = world.next_memory[row.pair];
      memory.impulse_ns = row.impulse_ns;
      memory.touching = row.gap_m <= 0 || row.total_ns > 0 || row.point_impulse_ns.squaredNorm() > 0;
    }
  });
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
    world.contacts[buffers.coloring.order()[k]] = contact_of(world, buffers.pairs[row.pair], row);
  }
  world.contacts_listed = true;
}

}  // namespace poise::simulation
