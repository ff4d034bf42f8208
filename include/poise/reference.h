// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace poise {

/// One frame compared with its reference. The reference is the same frame computed again from the same state, with
/// every candidate pair at its finest level, the contact model `fitted`, and solver iterations until impulses or
/// velocities have converged (docs/reference.md). A figure that is undefined for a frame is empty.
///
/// A body is *touched* if it is dynamic and a contact of the run or of the reference gave it an impulse. Let du = (dv,
/// dw) be the change of a body's velocity in the step, in the run and (with *) in the reference, m its mass and I its
/// inertia in the world frame. The error of a body, our definition, is
///     eps^2 = |dv - dv*|^2 + (dw - dw*) . I (dw - dw*) / m
/// A contact counts if its impulse is above 1e-9 of the largest of the frame. The reference has not converged below
/// that.
struct ReferenceFigures {
  bool converged = false;            ///< false: the iterations reached their limit; the figures are then less accurate
  std::uint32_t iterations = 0;      ///< of the reference's response, over the velocities of all pairs
  std::size_t pairs_not_finest = 0;  ///< a front was full: those pairs use the deepest level that fitted
  std::chrono::nanoseconds time{0};  ///< taken by the reference; included in no other time of the frame

  std::size_t bodies_touched = 0;
  std::optional<double> e_mps;       ///< E = sqrt(mean eps^2) over touched bodies, m/s; empty where none was touched
  std::optional<double> change_mps;  ///< C = sqrt(mean (|dv*|^2 + dw* . I dw* / m)) over the same bodies, m/s
  std::optional<double> e_rel;       ///< E / C; empty where C is 0
  /// sqrt(sum s eps^2 / sum s), m/s, with the weights s of error_weight; E without a view
  std::optional<double> e_seen_mps;

  std::size_t run_contacts = 0;        ///< pairs with an impulse in the run
  std::size_t reference_contacts = 0;  ///< pairs with an impulse in the reference
  std::size_t false_contacts = 0;      ///< impulse in the run, none in the reference
  std::size_t missed_contacts = 0;     ///< impulse in the reference, none in the run
  std::optional<double> false_rate;    ///< false_contacts / run_contacts
  std::optional<double> missed_rate;   ///< missed_contacts / reference_contacts

  /// Pairs with an impulse in the run whose true surfaces were separated at the start of the step ("repulsed at a
  /// distance").
  std::size_t contacts_apart = 0;
  std::optional<double> gap_mean_m;  ///< over contacts_apart; empty where there is none
  std::optional<double> gap_max_m;
  /// In pixels of a picture 1080 pixels high, seen from the viewer's position; empty without a view.
  std::optional<double> gap_mean_px;
  std::optional<double> gap_max_px;
};

}  // namespace poise
