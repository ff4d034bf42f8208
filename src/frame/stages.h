// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"

/// The stages of one step, in order. Each reads what those before it left in the World's buffers and counts its work in
/// the report. They belong to World::step and are called by it alone, from its thread.
namespace poise::simulation {

using TimePoint = SteadyClock::time_point;

/// The frame of refinement of an active pair, from the buffers of the frame.
collision::PairFrame frame_of(const WorldState& world, const ActivePair& pair);

/// May a pair that stays at level 0 be answered: is its likely gap less than its margin? A plane's always may.
bool coarsest_near(const WorldState& world, const ActivePair& pair);

/// What the host gave the bodies of an active pair, that of the lower slot first.
scheduler::UserData user_data_of(const WorldState& world, const ActivePair& pair);

/// A pair of which nothing was nearly near, is apart by so much more than its reach.
double wide_m(const ActivePair& pair);

/// Poses, inverse inertias and motion bounds from the state at the start of the step.
void predict(WorldState& world, const StepInput& input);

/// Candidate pairs, and of these the ones whose coarsest spheres are near: their first level, cues and memory.
void find_pairs(WorldState& world, const StepInput& input, FrameReport& report);

/// Refines until the budget says stop.
void refine(WorldState& world, const StepInput& input, FrameReport& report);

/// What a policy may know of the frame.
scheduler::FrameFacts frame_facts(const WorldState& world, const StepInput& input);
/// What decides when the next level of an active pair has its turn; `index` is its place among them.
double score_of(const WorldState& world, const scheduler::FrameFacts& facts, const ActivePair& pair,
                std::uint32_t index);
/// The next level of an active pair on one worker, whatever that costs; false when its front had no room.
bool refine_level(WorldState& world, ActivePair& pair, collision::LevelContact& found, int worker);

/// Brings one active pair to its deepest level on one worker, whatever that costs; false when its front had no room.
/// `found` is that of the pair.
bool refine_pair(WorldState& world, ActivePair& pair, collision::LevelContact& found, int worker);

/// Gives all pairs their places, and finds those that are answered. What is slower than `still_mps` is no impact.
void find_manifold_points(WorldState& world, double dt_s, double still_mps);
/// Lists the answered ones in canonical order and colours them by the bodies that yield.
void list_solved(WorldState& world, FrameReport& report);

/// Where the pairs are that are answered, and the velocities of the bodies: the first half of respond. What is slower
/// than `still_mps` is no impact.
void list_contact_pairs(WorldState& world, double dt_s, double still_mps, FrameReport& report);
/// Fills all rows with what impacts need; respond does so as they are looked at.
void fill_rows(WorldState& world);
/// What the solver of impacts works on, once there are rows.
solver::System impact_system(WorldState& world);
/// The place of an answered pair that answers impacts, where it was at the start of the frame.
solver::PlacedPoint impact_point_of(const WorldState& world, const ActivePair& pair);
/// The likely gap of its surfaces there; in the paper's model that of its spheres. `pair` is its place among the active
/// pairs.
double solved_gap_m(const WorldState& world, std::uint32_t pair);
/// Every active pair to its deepest level, whatever that costs, and its front forgotten: for the reference, which
/// answers no front. Counts pairs whose front had no room.
std::size_t refine_to_the_end(WorldState& world);

/// Impulses at the deepest completed level of each pair, and forces; velocities are those after the step.
solver::Convergence respond(WorldState& world, const StepInput& input, FrameReport& report,
                            const solver::Stopping& stopping = {});

/// Positions and orientations after the step.
void integrate(WorldState& world, const StepInput& input);

/// Events and the memory of pairs.
void publish(WorldState& world, const StepInput& input);

/// Which pairs of the last step are listed.
enum class ContactListing : std::uint8_t {
  Touching,  ///< those that touch, as events tell
  Answered,  ///< also those that were answered because they may touch within the step, and did not
};
/// The contacts of the last step but for bodies that were removed since, in order of slots. Any thread between steps.
std::vector<Contact> list_contacts(const WorldState& world, ContactListing listing);

/// Counted work of the tail with this many answered pairs; visits and coarse contacts are those of WorldState::times.
scheduler::TailWork tail_work(const WorldState& world, std::uint64_t contacts);

}  // namespace poise::simulation
