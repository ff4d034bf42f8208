// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "poise/decisions.h"
#include "poise/executor.h"
#include "poise/queries.h"
#include "poise/result.h"
#include "poise/scheduler/forecast.h"
#include "poise/scheduler/policy.h"
#include "poise/shape.h"
#include "poise/step.h"
#include "poise/types.h"

namespace poise {

namespace simulation {
struct WorldState;
class PairProbe;
struct WorldAccess;
}  // namespace simulation

/// How the contacts of one pair become an impulse (docs/method.md).
enum class ContactModel : std::uint8_t {
  Paper,   ///< every sphere contact in canonical order, once, each with the approach speed taken anew (DO eq. 1-5)
  Wrench,  ///< all sphere contacts together, weighted by overlap, one impulse a pair
  Fitted,  ///< all nodes together by the spheres fitted to their surface, one impulse a pair
};

/// A candidate pair that a PairFilter is asked about; a comes before b in the order of slots.
struct FilteredPair {
  BodyId a, b;
  std::uint64_t user_data_a = 0, user_data_b = 0;
};

/// A host's say in which bodies meet, beyond groups: returns false for a pair that is to pass through each other.
///
/// Called in the coarse stage of every step, once for each candidate pair whose bounding spheres come near each other
/// in the step and whose groups agree, from any thread and several at once. It must be pure (the same answer for the
/// same pair for as long as nothing that it reads is changed), quick, and neither throw nor call the World. What it
/// reads may be changed between steps. It is no part of the state: a replay needs the same filter.
struct PairFilter {
  bool (*function)(void* context, const FilteredPair& pair) = nullptr;  ///< null: all pairs meet, at no cost
  void* context = nullptr;
};

struct WorldSettings {
  Vec3 gravity_mps2 = Vec3::Zero();
  ContactModel contact = ContactModel::Fitted;
  scheduler::Policy policy;  ///< what is refined next
  ExecutorKind executor = ExecutorKind::Tbb;
  /// With ExecutorKind::Host, and only then: whose threads help (poise/executor.h). The World holds it while it lives.
  std::shared_ptr<HostExecutor> host_executor;
  /// Calling thread included; 0 = as many as the machine has, or as the host executor offers; at most 256.
  int threads = 0;
  /// A thread without work looks for it for this long before it sleeps: longer costs processor time, shorter costs tens
  /// of microseconds each time it has to be woken. In [0, 10 ms].
  Nanoseconds spin{50'000};
  /// Thread w (from 1; the calling thread is its owner's matter) runs on processors[w mod size] alone; empty: where the
  /// system puts it. Not with ExecutorKind::Tbb or Host, whose threads belong to others.
  std::vector<int> processors;
  int realtime_priority = 0;  ///< of those threads under SCHED_FIFO, 1 to 99; 0: as all threads. Likewise
  std::uint64_t seed = 1;
  /// Islands of bodies that have been still for half a second fall asleep: they stay where they are and cost next to
  /// nothing until something that moves comes near them or the caller touches one of them or what they lie on. Off,
  /// none of it is done.
  bool sleeping = false;
  int substeps = 2;  ///< of the resting-contact solver, 1 to 16
  /// Share of frames under a deadline whose tail may take longer than its reserve, in [1e-5, 0.5]. A smaller one needs
  /// a larger reserve.
  double alpha = scheduler::TrackedQuantile::kDefaultAlpha;
  std::uint32_t max_partners = 256;            ///< candidate partners that a body keeps, 1 to 65536
  std::uint32_t max_front_entries = 1U << 22;  ///< capacity for fronts, entries a worker thread, >= 64
};

struct Material {
  double restitution = 0;       ///< in [0, 1]; of two materials the larger counts
  double friction = 0;          ///< Coulomb's coefficient, >= 0; of two materials the geometric mean counts
  double density_kgpm3 = 1000;  ///< > 0
};

/// How a body moves.
enum class MotionType : std::uint8_t {
  Static,  ///< stays where it is put
  /// Moves by its velocity and angular velocity, which stay what the caller sets: a platform, a belt, a paddle. It
  /// pushes dynamic bodies and is pushed by none, meets neither static nor kinematic ones, wakes what sleeps in its way
  /// while it moves, and counts in no sum of mass, momentum or energy. Not for planes.
  Kinematic,
  Dynamic,  ///< moves by forces and contacts
};

struct BodyDefinition {
  ShapeId shape;
  MaterialId material;
  MotionType motion = MotionType::Dynamic;
  Vec3 position_m = Vec3::Zero();              ///< of the shape's own origin, world frame
  Quat orientation = Quat::Identity();         ///< body to world; normalised; not 0
  Vec3 velocity_mps = Vec3::Zero();            ///< of the centre of mass, world frame
  Vec3 angular_velocity_radps = Vec3::Zero();  ///< world frame
  double mass_kg = 0;                          ///< 0 = from volume and density
  Vec3 inertia_kgm2 = Vec3::Zero();            ///< principal moments in the shape's principal frame; 0 = from the shape
  std::uint32_t group = 1;                     ///< bits: which groups the body is in
  std::uint32_t collides_with = 0xffffffffU;   ///< bits: which groups it meets; both sides must agree
  double importance = 1;                       ///< a factor on the priority of its pairs, >= 0, finite
  /// The caller's own; nothing reads it but the caller's functions: PairFilter, and the cue and policy of a Policy.
  std::uint64_t user_data = 0;
};

struct BodyState {
  Vec3 position_m = Vec3::Zero();              ///< centre of mass, world frame
  Quat orientation = Quat::Identity();         ///< axes of the mesh, body to world, unit
  Vec3 velocity_mps = Vec3::Zero();            ///< of the centre of mass
  Vec3 angular_velocity_radps = Vec3::Zero();  ///< world frame
};

/// A point at which a pair touched in the last step, world frame, as the bodies were at the start of the step.
struct ContactPoint {
  Vec3 point_m = Vec3::Zero();     ///< in the middle between the surfaces
  Vec3 normal = Vec3::UnitZ();     ///< from a to b, unit
  double separation_m = 0;         ///< of the modelled surfaces along the normal, negative in overlap
  Vec3 impulse_ns = Vec3::Zero();  ///< that b received there in the step, kg m/s; a received the opposite
};

/// One pair that touched in the last step.
struct Contact {
  static constexpr std::size_t kMostPoints = 4;
  BodyId a, b;                     ///< a comes before b in the order of slots
  Level level = 0;                 ///< that was completed for the pair; by polygons, the trees' deepest + 1
  Vec3 normal = Vec3::UnitZ();     ///< from a to b, unit, mean over the pair
  Vec3 point_m = Vec3::Zero();     ///< world frame, mean over the pair
  double gap_m = 0;                ///< between the modelled surfaces at the start of the step, negative in overlap
  Vec3 impulse_ns = Vec3::Zero();  ///< that b received in the step, kg m/s; a received the opposite
  std::uint8_t point_count = 0;    ///< 1 to kMostPoints
  std::array<ContactPoint, kMostPoints> point_slots{};  ///< of these the first point_count
  /// The pair's manifold. The impulses of its points add up to impulse_ns; they are in the ratio of what the points
  /// carried at the end of the step, and equal where an impact alone was answered.
  [[nodiscard]] std::span<const ContactPoint> points() const { return std::span(point_slots).first(point_count); }
};

struct ContactEvent {
  enum class Kind : std::uint8_t {
    Begin,    ///< touches and did not in the step before
    End,      ///< touched in the step before and does not
    Persist,  ///< touches and did in the step before; only with StepInput::persist_events
  };
  Kind kind = Kind::Begin;
  BodyId a, b;
  Vec3 impulse_ns = Vec3::Zero();  ///< Begin, Persist: that b received in the step, kg m/s; End: 0
};

/// Sums over the dynamic bodies.
struct Conserved {
  Vec3 momentum_ns = Vec3::Zero();          ///< kg m/s
  Vec3 angular_momentum_js = Vec3::Zero();  ///< about the world origin, kg m^2/s
  double kinetic_j = 0;
  double potential_j = 0;  ///< -m g . x
};

/// A scene of rigid bodies that is stepped inside a budget. Invariant: every stored number is finite, and
/// inverse masses and inertias are >= 0.
///
/// One thread at a time may call a World; several Worlds may step at once. Bad arguments are refused by value and
/// leave the World as it was. step() does not allocate once its buffers have grown to the scene.
class World {
 public:
  /// Refused: gravity not finite; settings out of the ranges given above; processors that this process may not use; a
  /// priority that the system does not grant.
  static Result<World> create(const WorldSettings& settings);
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  /// A null pointer gives a ShapeId that no body may have.
  ShapeId add_shape(ShapePtr shape);
  Result<MaterialId> add_material(const Material& material);
  /// Refused: unknown ids, also those that were removed before, and shapes and materials that bodies use (the message
  /// says how many). An id is never given again, so a stale one is refused for good. Linear in the bodies.
  Status remove_shape(ShapeId shape);
  Status remove_material(MaterialId material);

  /// What this World goes by now.
  [[nodiscard]] const WorldSettings& settings() const;
  /// Changes the settings for the steps to come. Refused with the field, nothing being changed: what create() refuses,
  /// and a change of what is fixed when a World is made: executor, host_executor, threads, spin, processors,
  /// realtime_priority, max_front_entries. Another gravity, or sleeping turned off, wakes all bodies; another contact
  /// model clears the contact cache (not the accumulated impulses); another alpha makes the forecast of host work and
  /// the margin of the reserve learn anew. A record of the run holds the settings that it began with.
  Status set_settings(const WorldSettings& settings);
  /// The same for the policy alone. Refused: a weight that is not finite or < 0.
  Status set_policy(const scheduler::Policy& policy);
  /// From the next step on; an empty one (the default) lets all pairs meet. Wakes all bodies. Any pair that it now
  /// keeps apart ends its contact in the next step.
  void set_pair_filter(const PairFilter& filter);

  /// Refused: unknown shape or material, numbers that are not finite or out of range, an inertia that breaks the
  /// triangle inequality, a plane that is not static. Of static and kinematic bodies mass and inertia do not count.
  Result<BodyId> add_body(const BodyDefinition& definition);
  Status remove_body(BodyId body);
  [[nodiscard]] bool contains(BodyId body) const;
  [[nodiscard]] std::size_t body_count() const;  ///< static ones and planes included
  /// As it was added; a body that sleeps is dynamic.
  [[nodiscard]] Result<MotionType> motion_type(BodyId body) const;
  /// The bodies that live now, in order of slots; a copy, so it stays what it is when bodies come and go.
  [[nodiscard]] std::vector<BodyId> bodies() const;
  [[nodiscard]] Result<std::uint64_t> user_data(BodyId body) const;
  Status set_user_data(BodyId body, std::uint64_t user_data);

  [[nodiscard]] Result<BodyState> state(BodyId body) const;
  /// Wakes what sleeps there.
  Status set_state(BodyId body, const BodyState& state);
  /// Of the centre of mass, and about it; world frame. Wakes what sleeps there. Refused: numbers out of range, and a
  /// static body that is to move. A kinematic body keeps it until it is set again.
  Status set_velocity(BodyId body, const Vec3& velocity_mps, const Vec3& angular_velocity_radps);
  /// Does it sleep (WorldSettings::sleeping)? A body that sleeps has no velocity and no contacts.
  [[nodiscard]] Result<bool> asleep(BodyId body) const;
  /// 0 for static and kinematic bodies.
  [[nodiscard]] Result<double> mass_kg(BodyId body) const;
  [[nodiscard]] Result<ShapePtr> shape(BodyId body) const;

  /// Adds a force (N, world frame) at a world point for the next step; cleared by it. No effect on static and kinematic
  /// bodies; wakes sleeping ones.
  Status apply_force(BodyId body, const Vec3& force_n, const Vec3& point_m);
  Status apply_torque(BodyId body, const Vec3& torque_nm);
  /// Changes velocities at once by an impulse (kg m/s, world frame) at a world point.
  Status apply_impulse(BodyId body, const Vec3& impulse_ns, const Vec3& point_m);
  Status set_groups(BodyId body, std::uint32_t group, std::uint32_t collides_with);
  Status set_importance(BodyId body, double importance);

  // Queries (poise/queries.h): on true surfaces, as the bodies are now. Any number of threads at once, as long as none
  // steps or changes the World. Refused with field, value and rule: numbers that are not finite or out of range, a
  // direction that is zero, a negative radius or distance; stale handles.

  /// The first body that a ray hits; empty where it hits none.
  [[nodiscard]] Result<std::optional<RayHit>> cast_ray(const Ray& ray, const QueryFilter& filter = {}) const;
  /// The first body that a moving sphere touches; empty where it touches none.
  [[nodiscard]] Result<std::optional<SphereCastHit>> cast_sphere(const SphereCast& cast,
                                                                 const QueryFilter& filter = {}) const;
  /// Fills `found` with the bodies that meet a ball or, being solid, hold it, in order of slots; touching counts.
  Status overlap_sphere(const Vec3& center_m, double radius_m, std::vector<BodyId>& found,
                        const QueryFilter& filter = {}) const;
  /// The same of a box.
  Status overlap_box(const OrientedBox& box, std::vector<BodyId>& found, const QueryFilter& filter = {}) const;
  /// The nearest point of any body's surface, if it is within max_distance_m (>= 0, may be infinite); from inside a
  /// solid its surface may be the nearest.
  [[nodiscard]] Result<std::optional<ClosestPoint>> closest_point(const Vec3& point_m, double max_distance_m,
                                                                  const QueryFilter& filter = {}) const;
  /// The nearest point of one body's surface.
  [[nodiscard]] Result<ClosestPoint> closest_point(BodyId body, const Vec3& point_m) const;

  /// Tells how long the host's own work took in the frame that has just ended, for HostWork::learn; more than
  /// kFarthestTime counts as kFarthestTime.
  void report_host_work(Nanoseconds actual);

  /// The learned coefficients of the time forecasts, for a later run on the same machine; and a start from those of an
  /// earlier run, which replaces what this World has learned. Values out of range count as unknown. Neither is part of
  /// the state.
  [[nodiscard]] scheduler::TimePriors time_priors() const;
  void set_time_priors(const scheduler::TimePriors& priors);

  /// Steps once. The calling thread works too. Bad input is refused in FrameReport::status.
  FrameReport step(const StepInput& input);

  /// The pairs that touched in the last step, in order of (a, b): those whose surfaces met or that gave each other an
  /// impulse, as contact_events() counts them. Without the contacts of bodies that were removed since. Valid until the
  /// next call that is not const. Listed at the first call after a step, so a caller that does not ask does not pay;
  /// any number of threads may call it at once between steps.
  [[nodiscard]] std::span<const Contact> contacts() const;
  /// Pairs that began and ceased to touch in the last step, in order of (a, b), and those that went on if asked for.
  /// The contacts of a body that is removed end in the next step: then its handle stands in an End event, stale.
  [[nodiscard]] std::span<const ContactEvent> contact_events() const;

  /// What the last step's budget decided, put into `decisions` (its capacity is reused): the steps of refinement of all
  /// threads in the order in which they ended. Without StepInput::record in that step there are none.
  void decisions(FrameDecisions& decisions) const;

  [[nodiscard]] Conserved conserved() const;
  /// Every bit of state that the next step depends on, time forecasts aside (xxHash64).
  [[nodiscard]] std::uint64_t state_hash() const;
  [[nodiscard]] int threads() const;

 private:
  friend class simulation::PairProbe;
  friend struct simulation::WorldAccess;
  explicit World(std::unique_ptr<simulation::WorldState> state);
  std::unique_ptr<simulation::WorldState> state_;
};

}  // namespace poise
