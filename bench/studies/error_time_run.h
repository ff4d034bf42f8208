// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/compare/comparison.h"

/// How true a step is for the time that it takes: by Poise with deadlines or a level at most, and by other engines,
/// from the same states.
namespace poise::app {

/// What the setting of a way to step is.
enum class SettingKind : std::uint8_t {
  Deadline,    ///< Poise, in ms
  Level,       ///< Poise without a deadline, each pair to this level at most
  Iterations,  ///< another engine, of its solver
};

/// One way to step, with one setting.
struct StepMethod {
  std::string group;  ///< name of its curve: a policy, `levels`, or an engine
  SettingKind kind = SettingKind::Deadline;
  double setting = 0;
  scheduler::Policy policy = {};  ///< with a deadline
};

inline constexpr const char* kLevelsGroup = "levels";

struct ErrorTimeSettings {
  std::uint64_t bodies = 300;  ///< of the generators
  std::uint64_t seed = 1;      ///< of the intervals
  std::uint64_t warm_up = 60;  ///< frames before the first state
  std::uint64_t states = 16;
  std::uint64_t every = 10;    ///< frames from state to state
  std::uint64_t history = 10;  ///< frames that each method steps by itself from a state; the last one is measured
  std::vector<scheduler::Policy> policies;
  std::vector<double> deadlines_ms;
  std::vector<int> iterations;  ///< of other engines
};

/// What was measured of a method: one entry a state.
struct MethodRun {
  StepMethod method;
  std::vector<io::ComparedStep> steps;
  /// Of other engines: E_rel against what the engine itself does from the same state with kLimitIterations. It tells
  /// how far its solver has converged, without what it models otherwise than Poise.
  std::vector<std::optional<double>> own_e_rel;  ///< empty where nothing changed
};
inline constexpr int kLimitIterations = 3000;

struct ErrorTimeRun {
  std::vector<MethodRun> methods;
  std::vector<std::string> engines;  ///< other engines that took part, with version
  std::string why_none;              ///< where there are none
};

/// Steps a scene with everything refined; from each state each method steps `history` frames by itself. Its last frame
/// is held against the reference (docs/reference.md) of the state in which that frame began. Methods go in turns, state
/// by state. Other engines take part where they are built in and can have the scene: bodies of one shape made of
/// spheres in a tray. They begin each state without what they had cached of contacts. Whatever an engine models
/// otherwise counts as its error, as impacts that are answered a step later do. `told` gets the share that is done.
/// Refused: what the World refuses, and Ctrl-C.
Result<ErrorTimeRun> error_time_run(const Scene& scene, const SceneRunOptions& start, const ErrorTimeSettings& settings,
                                    const std::function<void(double share)>& told);

}  // namespace poise::app
