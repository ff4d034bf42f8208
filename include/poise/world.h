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
  Paper,   ///< every sphere contact once, in canonical order, each with the current approach speed (DO eq. 1-5)
  Wrench,  ///< all sphere contacts together, weighted by overlap, one impulse a pair
  Fitted,  ///< all nodes together by the spheres fitted to their surface, one impulse a pair
};

/// A candidate pair that is passed to a PairFilter; a comes before b in the order of slots.
struct FilteredPair {
  BodyId a, b;
  std::uint64_t user_data_a = 0, user_data_b = 0;
};

/// A host's filter of pairs, in addition to groups: returns false for two bodies that are to pass through each other.
///
/// Called in the coarse stage of every step, once for each candidate pair whose bounding spheres may meet in the step
/// and whose groups agree. Any thread may call it, several at once. It must be pure (the same result for the same pair
/// as long as its data is unchanged), fast, must not throw and must not call the World. Its data may change between
/// steps, but about bodies that sleep it is not asked: setting the filter again wakes all, and a body's user data wakes
/// that body. It is not part of the state: a replay needs the same filter.
struct PairFilter {
  bool (*function)(void* context, const FilteredPair& pair) = nullptr;  ///< null: all pairs collide, at no cost
  void* context = nullptr;                                              ///< passed to the function
};

/// Settings of a World; World::create refuses values out of the ranges given here.
struct WorldSettings {
  Vec3 gravity_mps2 = Vec3::Zero();  ///< world frame, each component within 1e9
  ContactModel contact = ContactModel::Fitted;
  scheduler::Policy policy;  ///< the order of refinement
  ExecutorKind executor = ExecutorKind::Tbb;
  /// With ExecutorKind::Host only: the host whose threads help (poise/executor.h). The World shares its ownership.
  std::shared_ptr<HostExecutor> host_executor;
  /// Number of threads, the calling thread included, at most 256; 0: as many as the machine has, or as the host
  /// executor offers.
  int threads = 0;
  /// Time for which a thread without work polls before it sleeps, in [0, 10 ms]. Longer costs processor time; shorter
  /// costs tens of microseconds for each wake-up.
  Nanoseconds spin{50'000};
  /// Thread w >= 1 runs only on processors[w mod size]; the affinity of the calling thread (w = 0) is not changed.
  /// Empty: no affinity. Not with ExecutorKind::Tbb or Host, whose threads are not owned by the World.
  std::vector<int> processors;
  int realtime_priority = 0;  ///< of these threads under SCHED_FIFO, 1 to 99; 0: default. Not with Tbb or Host
  std::uint64_t seed = 1;     ///< of policies that draw random numbers
  /// Islands of bodies that have been still for half a second fall asleep. Sleeping bodies do not move and cost almost
  /// nothing. They wake when a moving body comes near, or when the caller changes one of them or a body that they rest
  /// on. Costs nothing if off.
  bool sleeping = false;
  /// Where a frame would not meet its deadline, or has no time to refine, islands may wait, for up to seven steps in a
  /// row, out of the view of a viewer up to 31 (a step is one frame, or with StepInput::may_slice several): their
  /// bodies keep position and velocity and get no forces, and their contacts go on without being listed. Where not even
  /// finding the pairs of all bodies fits, they take turns, and are not looked at in between (Degraded::bodies_paused),
  /// unless a moving body, the caller or the view comes near them. What moves in them is seen in slow motion meanwhile,
  /// and is as accurate as without. Those near rest wait first (docs/scheduling.md says what that is), and with
  /// NearRest no others. Counted in Degraded::bodies_held. Never without gravity, with StepInput::backtracking, or
  /// without a deadline.
  IslandsWait islands_wait = IslandsWait::Any;
  int substeps = 2;  ///< of the contact solver, 1 to 16
  /// Share of frames with a deadline whose tail may take longer than its reserve, in [1e-5, 0.5]. A smaller share needs
  /// a larger reserve.
  double alpha = scheduler::TrackedQuantile::kDefaultAlpha;
  std::uint32_t max_partners = 256;  ///< capacity for the candidate partners of a body, 1 to 65536
  /// Capacity for the candidate pairs of all bodies, 1024 to 2^28; where there are more, each body has its equal share
  /// (its nearest partners). Pairs with planes and of fast bodies with backtracking are never left out. A pair takes
  /// about 2.4 kB.
  std::uint32_t max_pairs = 1U << 24;
  std::uint32_t max_front_entries = 1U << 22;  ///< capacity for fronts, entries per worker thread, 64 to 2^26
};

/// The surface and density of a body.
struct Material {
  double restitution = 0;       ///< in [0, 1]; a pair uses the larger of its two
  double friction = 0;          ///< Coulomb's coefficient, in [0, 1e6]; a pair uses the geometric mean of its two
  double density_kgpm3 = 1000;  ///< in [1e-9, 1e12]
};

/// How a body moves.
enum class MotionType : std::uint8_t {
  Static,  ///< does not move
  /// Moves with the velocity and angular velocity that the caller sets: a platform, a belt, a paddle. It pushes dynamic
  /// bodies and no body pushes it. It does not collide with static or kinematic bodies. While it moves it wakes
  /// sleeping bodies in its way. It is not included in sums of mass, momentum or energy. Not for planes.
  Kinematic,
  Dynamic,  ///< moves by forces and contacts
};

/// A body to be added. Positions are limited to 1e12 m, speeds to 1e9 m/s and 1e9 rad/s, each component.
struct BodyDefinition {
  ShapeId shape;
  MaterialId material;
  MotionType motion = MotionType::Dynamic;
  Vec3 position_m = Vec3::Zero();              ///< of the origin of the shape's mesh or list of spheres, world frame
  Quat orientation = Quat::Identity();         ///< body to world; normalised; norm above 1e-9
  Vec3 velocity_mps = Vec3::Zero();            ///< of the centre of mass, world frame
  Vec3 angular_velocity_radps = Vec3::Zero();  ///< world frame
  double mass_kg = 0;                          ///< in [1e-18, 1e18]; 0: from volume and density
  Vec3 inertia_kgm2 = Vec3::Zero();            ///< principal moments in the shape's principal frame; 0: from the shape
  std::uint32_t group = 1;                     ///< bits: which groups the body is in
  std::uint32_t collides_with = 0xffffffffU;   ///< bits: which groups it collides with; both bodies must agree
  double importance = 1;                       ///< factor on the priority of its pairs, in [0, 1e6]
  /// The caller's value. Only the caller's functions read it: PairFilter, and the cue and policy of a Policy.
  std::uint64_t user_data = 0;
};

/// Position and motion of a body. Limits as in BodyDefinition.
struct BodyState {
  Vec3 position_m = Vec3::Zero();              ///< centre of mass, world frame
  Quat orientation = Quat::Identity();         ///< axes of the mesh, body to world, unit
  Vec3 velocity_mps = Vec3::Zero();            ///< of the centre of mass, world frame
  Vec3 angular_velocity_radps = Vec3::Zero();  ///< world frame
};

/// A contact point of the last step, in the world frame, with the bodies at their positions at the start of the step.
struct ContactPoint {
  Vec3 point_m = Vec3::Zero();     ///< midway between the surfaces
  Vec3 normal = Vec3::UnitZ();     ///< from a to b, unit
  double separation_m = 0;         ///< of the modelled surfaces along the normal, metres, negative in overlap
  Vec3 impulse_ns = Vec3::Zero();  ///< received by b at this point in the step, kg m/s; a received the opposite
};

/// A pair that touched in the last step.
struct Contact {
  static constexpr std::size_t kMostPoints = 8;
  BodyId a, b;                  ///< a comes before b in the order of slots
  Level level = 0;              ///< completed for the pair; for polygons, the deepest level of its trees + 1
  Vec3 normal = Vec3::UnitZ();  ///< from a to b, unit, mean over the pair
  Vec3 point_m = Vec3::Zero();  ///< world frame, mean over the pair
  double gap_m = 0;             ///< separation of the modelled surfaces at the start of the step, negative in overlap
  Vec3 impulse_ns = Vec3::Zero();                       ///< received by b in the step, kg m/s; a received the opposite
  std::uint8_t point_count = 0;                         ///< 1 to kMostPoints
  std::array<ContactPoint, kMostPoints> point_slots{};  ///< the first point_count entries are valid
  /// The pair's manifold. The impulses of its points add up to impulse_ns. They have the ratio of the points'
  /// accumulated impulses at the end of the step, and are equal if the pair had an impact alone.
  [[nodiscard]] std::span<const ContactPoint> points() const { return std::span(point_slots).first(point_count); }
};

/// A change of the contact of a pair in the last step.
struct ContactEvent {
  enum class Kind : std::uint8_t {
    Begin,    ///< touches now and did not in the previous step
    End,      ///< touched in the previous step and does not now
    Persist,  ///< touched in the previous step and still does; only with StepInput::persist_events
  };
  Kind kind = Kind::Begin;
  BodyId a, b;
  Vec3 impulse_ns = Vec3::Zero();  ///< Begin, Persist: received by b in the step, kg m/s; End: 0
};

/// Sums over the dynamic bodies.
struct Conserved {
  Vec3 momentum_ns = Vec3::Zero();          ///< kg m/s
  Vec3 angular_momentum_js = Vec3::Zero();  ///< about the world origin, kg m^2/s
  double kinetic_j = 0;
  double potential_j = 0;  ///< -m g . x
};

/// A scene of rigid bodies that is stepped within a time budget. Invariant: every stored number is finite, and inverse
/// masses and inertias are >= 0.
///
/// One thread at a time may call a World; several Worlds may step at once. A call with bad arguments returns an error
/// and leaves the World unchanged. step() does not allocate once its buffers have grown to the size of the scene.
class World {
 public:
  /// Refused: gravity that is not finite; settings out of the ranges given above; processors that this process may not
  /// use; a realtime priority that the system does not grant.
  static Result<World> create(const WorldSettings& settings);
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  // Every call with a BodyId, except contains(), refuses a stale handle as ErrorKind::StaleHandle.

  /// Adds a shape, which bodies may then use. A null pointer gives a ShapeId that add_body refuses.
  ShapeId add_shape(ShapePtr shape);
  /// Refused: values out of the ranges of Material.
  Result<MaterialId> add_material(const Material& material);
  /// Removes a shape or material. Refused: ids that are unknown or were removed before; shapes and materials in use
  /// (the message gives the number of bodies). Ids are never reused, so a stale id is always refused. Takes time linear
  /// in the bodies.
  Status remove_shape(ShapeId shape);
  Status remove_material(MaterialId material);

  /// The current settings.
  [[nodiscard]] const WorldSettings& settings() const;
  /// Changes the settings for the following steps. Refused with the field, and nothing changes: values that create()
  /// refuses, and a change of a setting that is fixed at creation: executor, host_executor, threads, spin, processors,
  /// realtime_priority, max_front_entries. A change of gravity, or turning sleeping off, wakes all bodies. A change of
  /// the contact model clears the contact cache (not the accumulated impulses). A change of alpha restarts the learning
  /// of the host-work forecast and of the reserve's margin. A record of a run holds the settings at its start.
  Status set_settings(const WorldSettings& settings);
  /// Changes WorldSettings::policy alone. Refused: a policy with a problem (scheduler::first_problem).
  Status set_policy(const scheduler::Policy& policy);
  /// Sets the pair filter for the following steps; an empty one (the default) lets all pairs collide. Wakes all bodies.
  /// A contact of a pair that the filter now excludes ends in the next step.
  void set_pair_filter(const PairFilter& filter);

  /// Adds a body. Refused: unknown shape or material, numbers that are not finite or out of range, an inertia that
  /// breaks the triangle inequality, a plane that is not static. Mass and inertia of static and kinematic bodies have
  /// no effect. Wakes sleeping bodies near it.
  Result<BodyId> add_body(const BodyDefinition& definition);
  /// What add_body would say of this body, which is not added: nothing changes. For batches of which all are to be
  /// added or none.
  [[nodiscard]] Status check_body(const BodyDefinition& definition) const;
  /// Removes a body; its handle becomes stale. Wakes its island and, for a static body, sleeping bodies near it.
  Status remove_body(BodyId body);
  [[nodiscard]] bool contains(BodyId body) const;
  [[nodiscard]] std::size_t body_count() const;  ///< static ones and planes included
  /// The motion type given to add_body; a sleeping body is Dynamic.
  [[nodiscard]] Result<MotionType> motion_type(BodyId body) const;
  /// Handles of all bodies, in order of slots. A copy: adding and removing bodies does not change it.
  [[nodiscard]] std::vector<BodyId> bodies() const;
  [[nodiscard]] Result<std::uint64_t> user_data(BodyId body) const;
  Status set_user_data(BodyId body, std::uint64_t user_data);

  [[nodiscard]] Result<BodyState> state(BodyId body) const;
  /// Sets position, orientation and velocities. Wakes the body, at the next step the rest of its island, and for a
  /// static body those near its old and new position. Refused: numbers out of range, and a velocity for a static body.
  Status set_state(BodyId body, const BodyState& state);
  /// Sets the velocity of the centre of mass and the angular velocity about it, world frame. Wakes as set_state.
  /// Refused: numbers out of range, and a velocity for a static body. A kinematic body keeps it until it is set again.
  Status set_velocity(BodyId body, const Vec3& velocity_mps, const Vec3& angular_velocity_radps);
  /// Whether a body sleeps (WorldSettings::sleeping). A sleeping body has no velocity and no contacts.
  [[nodiscard]] Result<bool> asleep(BodyId body) const;
  /// Mass, kg; 0 for static and kinematic bodies.
  [[nodiscard]] Result<double> mass_kg(BodyId body) const;
  [[nodiscard]] Result<ShapePtr> shape(BodyId body) const;

  /// Adds a force (N, world frame) at a world point for the next step, which clears it. No effect on static and
  /// kinematic bodies; wakes sleeping ones. Refused: point_m beyond 1e12 m, and a sum of forces (N) or torques (N m)
  /// beyond 1e30, each component.
  Status apply_force(BodyId body, const Vec3& force_n, const Vec3& point_m);
  /// Adds a torque (N m, world frame) for the next step, otherwise as apply_force.
  Status apply_torque(BodyId body, const Vec3& torque_nm);
  /// Changes velocities immediately by an impulse (kg m/s, world frame) at a world point. No effect on static and
  /// kinematic bodies; wakes sleeping ones. Refused: arguments or resulting velocities out of range.
  Status apply_impulse(BodyId body, const Vec3& impulse_ns, const Vec3& point_m);
  /// Sets BodyDefinition::group and collides_with. Wakes as set_state.
  Status set_groups(BodyId body, std::uint32_t group, std::uint32_t collides_with);
  /// Sets BodyDefinition::importance. Refused: a value out of [0, 1e6].
  Status set_importance(BodyId body, double importance);

  // Queries (poise/queries.h): on the true surfaces, at the current positions of the bodies. Any number of threads at
  // once, as long as no thread steps or changes the World. Refused with field, value and rule: numbers that are not
  // finite or out of range, a direction that is zero, a negative radius or distance; stale handles.

  /// The first body that a ray hits; empty if it hits none.
  [[nodiscard]] Result<std::optional<RayHit>> cast_ray(const Ray& ray, const QueryFilter& filter = {}) const;
  /// The first body that a moving sphere touches; empty if it touches none.
  [[nodiscard]] Result<std::optional<SphereCastHit>> cast_sphere(const SphereCast& cast,
                                                                 const QueryFilter& filter = {}) const;
  /// Fills `found` with the bodies that overlap a ball (touching counts) or, being solid, contain it, in order of
  /// slots.
  Status overlap_sphere(const Vec3& center_m, double radius_m, std::vector<BodyId>& found,
                        const QueryFilter& filter = {}) const;
  /// The same for a box.
  Status overlap_box(const OrientedBox& box, std::vector<BodyId>& found, const QueryFilter& filter = {}) const;
  /// The nearest point on any body's surface within max_distance_m (>= 0, may be infinite); empty if there is none. For
  /// a point inside a solid, the solid's own surface is included.
  [[nodiscard]] Result<std::optional<ClosestPoint>> closest_point(const Vec3& point_m, double max_distance_m,
                                                                  const QueryFilter& filter = {}) const;
  /// The nearest point on one body's surface.
  [[nodiscard]] Result<ClosestPoint> closest_point(BodyId body, const Vec3& point_m) const;

  /// Reports the duration of the host's own work in the frame that has just ended, for HostWork::learn. Durations above
  /// kFarthestTime count as kFarthestTime.
  void report_host_work(Nanoseconds actual);

  /// Read and set the learned coefficients of the time forecasts, for a later run on the same machine. Setting replaces
  /// everything that this World has learned; values out of range count as unknown. They are not part of the state.
  [[nodiscard]] scheduler::TimePriors time_priors() const;
  void set_time_priors(const scheduler::TimePriors& priors);

  /// Steps once. The calling thread works too. Refuses bad input with FrameReport::status.
  FrameReport step(const StepInput& input);
  /// Whether the last step goes on in the next call (StepInput::may_slice). Until then bodies are where they were
  /// before it, and contacts() are those of the step before if they were asked for before it began, else none. Any call
  /// that changes the World ends such a step first, however long it takes, and what is recorded of it cannot be
  /// replayed: hosts keep their changes until no step is unfinished.
  [[nodiscard]] bool step_unfinished() const;
  /// Waits for threads that the last step did not wait for (FrameReport::jobs_abandoned), each for at most a level of a
  /// pair. Only a policy's own function (scheduler::HostPolicy) may still be called on such a thread after the step:
  /// call this before what it reads is changed. Calls that change the World, the next step among them, do it
  /// themselves.
  void wait_for_workers();

  /// The pairs that touched in the last step, in order of (a, b), by the definition of contact_events(): their surfaces
  /// met or they exchanged an impulse. Contacts of bodies that were removed since are omitted, and those of bodies that
  /// waited in that step (WorldSettings::islands_wait). Valid until the next non-const call. The list is built at the
  /// first call after a step, so it costs nothing if unused. Any number of threads may call it at once between steps.
  [[nodiscard]] std::span<const Contact> contacts() const;
  /// Pairs that began or ceased to touch in the last step, in order of (a, b), and with StepInput::persist_events those
  /// that continued. The contacts of a removed body end in the next step; its handle in the End event is stale.
  [[nodiscard]] std::span<const ContactEvent> contact_events() const;

  /// Writes the last step's decisions to `decisions`, whose capacity is reused: the refinement steps of all threads in
  /// the order of completion. Empty unless that step had StepInput::record.
  void decisions(FrameDecisions& decisions) const;

  /// Momentum, angular momentum and energy of the dynamic bodies.
  [[nodiscard]] Conserved conserved() const;
  /// Hash (xxHash64) of all state that the next step depends on, except time forecasts.
  [[nodiscard]] std::uint64_t state_hash() const;
  /// Number of threads that may work on a step, the calling thread included.
  [[nodiscard]] int threads() const;

 private:
  friend class simulation::PairProbe;
  friend struct simulation::WorldAccess;
  explicit World(std::unique_ptr<simulation::WorldState> state);
  std::unique_ptr<simulation::WorldState> state_;
};

}  // namespace poise
