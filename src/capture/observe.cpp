// SPDX-License-Identifier: MIT
#include "capture/observe.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "poise/scheduler/bands.h"
#include "verify/world_access.h"

namespace poise::capture {
namespace {

std::uint32_t clamped(std::uint64_t count) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(count, std::numeric_limits<std::uint32_t>::max()));
}

std::array<float, 3> floats_of(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

void put_view(const View& view, FrameFacts& facts) {
  facts.has_view = view.present;
  if (!view.present) return;
  facts.position_m = {view.position_m.x(), view.position_m.y(), view.position_m.z()};
  facts.forward = floats_of(view.forward);
  facts.up = floats_of(view.up);
  facts.gaze = floats_of(view.gaze);
  facts.vertical_fov_rad = static_cast<float>(view.vertical_fov_rad);
  facts.aspect = static_cast<float>(view.aspect);
}

BodyActivity activity_of(const simulation::WorldState& world, std::uint32_t slot) {
  const dynamics::BodyStore& bodies = world.bodies;
  if (bodies.kinematic[slot] != 0) return BodyActivity::Kinematic;
  if (bodies.paused[slot] != 0) return BodyActivity::Paused;
  if (bodies.asleep[slot] != 0) return BodyActivity::Asleep;
  if (bodies.dynamic[slot] == 0) return BodyActivity::Static;
  const simulation::HeldIslands& held = world.outputs.levels.held;
  return slot < held.slots.size() && held.holds(slot) ? BodyActivity::Held : BodyActivity::Moving;
}

// The level of a contact, polygons apart from the levels of trees.
Level level_of(const dynamics::BodyStore& bodies, const Contact& contact) {
  const auto depth = [&](BodyId body) {
    const Shape& shape = *bodies.shape[body.slot];
    return shape.kind == ShapeKind::Plane ? Level{0} : shape.tree.depth();
  };
  return contact.level > std::max(depth(contact.a), depth(contact.b)) ? kPolygonBin : contact.level;
}

PairSource source_of(simulation::ContactState state) {
  switch (state) {
    case simulation::ContactState::Coarsest:
      return PairSource::Coarsest;
    case simulation::ContactState::Cached:
      return PairSource::Cached;
    case simulation::ContactState::Refined:
      return PairSource::Refined;
    case simulation::ContactState::Exact:
      return PairSource::Exact;
    case simulation::ContactState::CachedSeparated:
      return PairSource::CachedSeparated;
    case simulation::ContactState::Separated:
      return PairSource::Separated;
  }
  return PairSource::Coarsest;
}

// Calls use(a, b, progress) for the slots of all near pairs of the last step, in canonical order.
template <class Use>
void for_each_near(const simulation::WorldState& world, const Use& use) {
  const simulation::Frame& frame = world.outputs;
  const simulation::PairTable& table = frame.table;
  table.for_each_near([&](std::size_t i) { use(table.pairs[i].a, table.pairs[i].b, frame.levels.progress[i]); },
                      [&](const simulation::CachedPair& cached) {
                        const simulation::ActivePair pair =
                            simulation::near_pair(table.terms, frame.motion, {cached.low, cached.high}, cached);
                        simulation::PairProgress progress =
                            simulation::progress_of_apart(world.scene(), table.terms, frame.motion, pair);
                        progress.held = frame.levels.held.holds(pair.a) || frame.levels.held.holds(pair.b);
                        use(pair.a, pair.b, progress);
                      });
}

std::uint8_t captured_level(const simulation::PairProgress& progress) {
  return progress.by_polygons() ? static_cast<std::uint8_t>(kPolygonBin)
                                : std::min<std::uint8_t>(progress.solved_level(), kMaxTreeDepth);
}

}  // namespace

std::uint32_t captured_time(Nanoseconds time) {
  return clamped(static_cast<std::uint64_t>(std::max<std::int64_t>(time.count(), 0)) / 100);
}

std::array<float, 3> captured_momentum(const Vec3& momentum_ns) {
  const Eigen::Vector3f rounded = momentum_ns.cast<float>();
  return {rounded.x(), rounded.y(), rounded.z()};
}

FrameFacts facts_of_start(const View& view) {
  FrameFacts facts;
  put_view(view, facts);
  return facts;
}

FrameFacts facts_of(const FrameReport& report, const View& view, double dt_s) {
  FrameFacts facts;
  facts.frame = report.frame + 1;
  facts.time_s = static_cast<double>(facts.frame) * dt_s;
  facts.measured = true;
  facts.cause = report.cause;
  put_view(view, facts);
  const StageTimes& t = report.times;
  const std::array<Nanoseconds, 10> times{t.predict, t.broad_phase, t.coarse,  t.refine, t.manifolds,
                                          t.solve,   t.integrate,   t.publish, t.total,  report.host_actual};
  for (std::size_t i = 0; i < times.size(); ++i) facts.times[i] = captured_time(times[i]);
  facts.budget = captured_time(report.budget);
  facts.reserve = captured_time(report.reserve_at_cut);
  facts.lateness = captured_time(report.lateness);
  const std::array<std::uint64_t, 10> counts{report.bodies,
                                             report.candidate_pairs,
                                             report.coarse_pairs,
                                             report.contact_pairs,
                                             report.pairs_left,
                                             report.jobs_done,
                                             report.jobs_discarded,
                                             report.asleep,
                                             report.degraded.bodies_held,
                                             report.degraded.bodies_paused};
  for (std::size_t i = 0; i < counts.size(); ++i) facts.counts[i] = clamped(counts[i]);
  std::ranges::copy(report.level_histogram, facts.levels.begin());
  facts.work = report.work_refine;
  return facts;
}

void find_gaze(const View& view, const std::array<double, 2>& resolution_px, FrameFacts& facts) {
  const double ahead = view.gaze.dot(view.forward);
  if (!view.present || ahead <= 0) return;
  const Vec3 right = view.forward.cross(view.up).normalized();
  const Vec3 upward = right.cross(view.forward);
  const double focal_px = 0.5 * resolution_px[1] / std::tan(0.5 * view.vertical_fov_rad);
  facts.gaze_px = {static_cast<float>(0.5 * resolution_px[0] + focal_px * view.gaze.dot(right) / ahead),
                   static_cast<float>(0.5 * resolution_px[1] - focal_px * view.gaze.dot(upward) / ahead)};
}

void FrameObserver::find_levels() {
  const simulation::WorldState& world = simulation::WorldAccess::of(run_.world());
  const std::size_t slots = world.bodies.slot_count();
  level_.resize(slots, 0);
  priority_.resize(slots, 0);
  number_.resize(slots, 0);
  // What the step before found goes on, and its outputs are being made anew.
  if (run_.world().step_unfinished()) return;
  found_.assign(slots, 0);
  seen_.assign(slots, 0);
  for_each_near(world, [&](std::uint32_t a, std::uint32_t b, const simulation::PairProgress& progress) {
    const Level level = progress.by_polygons() ? kPolygonBin : std::min<Level>(progress.solved_level(), kMaxTreeDepth);
    for (const std::uint32_t slot : {a, b}) {
      found_[slot] = std::max(found_[slot], static_cast<std::uint8_t>(level + 1));
      seen_[slot] = std::max(seen_[slot], progress.seen);
    }
  });
  for (std::size_t slot = 0; slot < slots; ++slot) {
    if (found_[slot] == 0 && world.bodies.asleep[slot] != 0) continue;
    level_[slot] = found_[slot];
    priority_[slot] = seen_[slot];
  }
}

void FrameObserver::find_contacts(SeenFrame& frame) const {
  const dynamics::BodyStore& bodies = simulation::WorldAccess::of(run_.world()).bodies;
  for (const Contact& contact : run_.world().contacts()) {
    SeenContact& seen = frame.contacts.emplace_back();
    seen.a = number_[contact.a.slot];
    seen.b = number_[contact.b.slot];
    seen.level = level_of(bodies, contact);
    seen.normal = contact.normal;
    seen.point_count = contact.point_count;
    for (std::size_t point = 0; point < contact.point_count; ++point)
      seen.points_m[point] = contact.point_slots[point].point_m;
  }
}

void FrameObserver::find_pairs(SeenFrame& frame) const {
  if (run_.world().step_unfinished()) return;
  const simulation::WorldState& world = simulation::WorldAccess::of(run_.world());
  const auto error_m = [&](std::uint32_t slot, std::uint8_t level) {
    return level == kPolygonBin ? 0.0 : static_cast<double>(world.shapes[world.shape_of[slot]].error_m[level]);
  };
  for_each_near(world, [&](std::uint32_t a, std::uint32_t b, const simulation::PairProgress& progress) {
    SeenPair& seen = frame.pairs.emplace_back();
    seen.a = number_[a];
    seen.b = number_[b];
    seen.packed.state = static_cast<std::uint8_t>(source_of(progress.state()));
    if (progress.held) seen.packed.state |= kPairWaits;
    if (progress.refinable()) seen.packed.state |= kPairLeft;
    seen.packed.level = captured_level(progress);
    seen.packed.deepest = progress.level.polygons ? static_cast<std::uint8_t>(kPolygonBin)
                                                  : std::min<std::uint8_t>(progress.level.deepest, kMaxTreeDepth);
    seen.packed.seen = progress.seen;
    const double error = error_m(a, seen.packed.level) + error_m(b, seen.packed.level);
    seen.packed.error = static_cast<std::uint8_t>(scheduler::octave_band(error));
    seen.packed.outcome = static_cast<std::uint8_t>(static_cast<int>(outcome_of(progress)) + 1);
    seen.packed.turn = progress.turn;
  });
}

Status FrameObserver::observe(SeenFrame& frame) {
  const simulation::WorldState& world = simulation::WorldAccess::of(run_.world());
  find_levels();
  for (const RunBody& body : run_.bodies()) {
    const std::uint32_t slot = body.id.slot;
    if (!world.bodies.contains(body.id))
      return Error{ErrorKind::StaleHandle, "a body of the scene was removed from the World"};
    number_[slot] = body.number;
    if (body.number >= next_number_) {
      next_number_ = body.number + 1;
      CapturedBody& row = frame.new_bodies.emplace_back();
      row.number = body.number;
      row.shape = static_cast<std::uint32_t>(body.shape);
      row.material = static_cast<std::uint32_t>(body.material);
      row.motion = body.motion;
      row.mass_kg = body.motion == MotionType::Dynamic ? world.bodies.mass_kg[slot] : 0;
      if (body.number < scene_.bodies.size()) row.name = scene_.bodies[body.number].name;
    }
    frame.bodies.push_back({body.number,
                            {world.bodies.position(slot), world.bodies.orientation(slot)},
                            static_cast<std::uint8_t>(activity_of(world, slot)),
                            level_[slot],
                            priority_[slot]});
  }
  if (contacts_) find_contacts(frame);
  if (pairs_) find_pairs(frame);
  return Done{};
}

}  // namespace poise::capture
