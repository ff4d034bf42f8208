// SPDX-License-Identifier: MIT
#include "studies/crowd_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "app/process/refusal.h"
#include "parallel/interrupt.h"
#include "scene/run/percentiles.h"
#include "verify/reference.h"
#include "verify/world_access.h"

namespace poise::app {
namespace {

using simulation::Reference;
using simulation::ReferenceContacts;

double share_of(std::size_t part, std::size_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : std::numeric_limits<double>::quiet_NaN();
}

// The references of one frame. Invariant: all remember the same state.
class FrameReferences {
 public:
  explicit FrameReferences(std::size_t count) : references_(count) {
    for (auto& reference : references_) reference = std::make_unique<Reference>();
  }
  void remember(simulation::WorldState& state) {
    for (const auto& reference : references_) simulation::remember(state, *reference);
  }
  Reference& make(simulation::WorldState& state, const StepInput& input, std::size_t which,
                  const ReferenceContacts& contacts) {
    make_reference(state, input, state.pools, *references_[which], contacts);
    return *references_[which];
  }

 private:
  std::vector<std::unique_ptr<Reference>> references_;
};

}  // namespace

void CrowdErrors::add(const ReferenceFigures& figures) {
  run_contacts_ += figures.run_contacts;
  reference_contacts_ += figures.reference_contacts;
  false_ += figures.false_contacts;
  missed_ += figures.missed_contacts;
  if (!figures.e_rel) return;
  e_rel_.push_back(*figures.e_rel);
  const auto bodies = static_cast<double>(figures.bodies_touched);
  error2_ += bodies * *figures.e_mps * *figures.e_mps;
  change2_ += bodies * *figures.change_mps * *figures.change_mps;
}

double CrowdErrors::median() const {
  return e_rel_.empty() ? std::numeric_limits<double>::quiet_NaN() : simulation::percentile(e_rel_, 0.5);
}

double CrowdErrors::together() const { return std::sqrt(error2_ / change2_); }
double CrowdErrors::false_share() const { return share_of(false_, run_contacts_); }
double CrowdErrors::missed_share() const { return share_of(missed_, reference_contacts_); }

std::vector<CrowdLevel> levels_of(SceneRun& run) {
  std::size_t deepest = 0;
  for (const auto& shape : simulation::WorldAccess::of(run.world()).shapes)
    deepest = std::max<std::size_t>(deepest, shape.shape->tree.depth());
  std::vector<CrowdLevel> levels;
  for (std::size_t level = 0; level <= deepest; ++level) levels.push_back({static_cast<Level>(level), false});
  levels.push_back({kMaxTreeDepth, true});
  return levels;
}

Status add_crowd_frames(SceneRun& run, const StepInput& input, const CrowdLevel& level, std::uint64_t frames,
                        std::uint64_t every, std::span<const simulation::ContactNoise> noises,
                        const std::function<void(double share)>& told, CrowdFrames& into) {
  const parallel::Interrupt interrupt;
  simulation::WorldState& state = simulation::WorldAccess::of(run.world());
  FrameReferences references(2 + noises.size());
  into.disturbed.resize(std::max(into.disturbed.size(), noises.size()));
  for (std::uint64_t k = 0; k < frames; ++k) {
    const Status ready = run.before_frame(k);
    if (!ready) return ready;
    StepInput step = input;
    step.view = run.view();
    step.max_level = level.max_level;
    step.polygons = level.polygons;
    const bool compared = (k + 1) % every == 0;
    if (compared) references.remember(state);
    if (run.world().step(step).status != StepStatus::Done) return bad_input("a step was refused");
    told(static_cast<double>(k + 1) / static_cast<double>(frames));
    if (interrupt.asked()) return stopped_error();
    if (!compared) continue;
    state.settle();
    step.view = {};
    Reference& exact = references.make(state, step, 0, {});
    Reference& of_level = references.make(state, step, 1, {level.max_level, level.polygons, {}});
    std::vector<ReferenceFigures> disturbed;
    for (std::size_t n = 0; n < noises.size(); ++n) {
      const Reference& other = references.make(state, step, 2 + n, {kMaxTreeDepth, true, noises[n]});
      disturbed.push_back(compare_references(state, other, exact));
    }
    const ReferenceFigures contacts = compare_references(state, of_level, exact);
    const bool converged = contacts.converged && std::ranges::all_of(disturbed, &ReferenceFigures::converged);
    if (!converged) {
      ++into.not_converged;
      continue;
    }
    into.whole.add(compare_with(state, step, exact));
    into.contacts.add(contacts);
    into.response.add(compare_with(state, step, of_level));
    for (std::size_t n = 0; n < noises.size(); ++n) into.disturbed[n].add(disturbed[n]);
  }
  return Done{};
}

}  // namespace poise::app
