// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "oracle/oracle_mesh.h"

namespace poise::oracle {

/// A body without forces: constant velocity of the centre of mass, constant angular velocity in the world.
struct Flight {
  Placed start;
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 spin_radps = Vec3::Zero();

  /// The pose `time_s` after the start; negative times are before it.
  [[nodiscard]] Placed at(double time_s) const;
};

enum class FlightOutcome : std::uint8_t {
  Touch,
  Miss,
  StartsTouching,  ///< nearer than the tolerance at the start
  Undecided,       ///< stayed so close, without touching, that the search was abandoned
};

/// The first contact of two bodies in free flight.
struct FirstTouch {
  FlightOutcome outcome = FlightOutcome::Miss;
  double time_s = 0;
  Placed a, b;              ///< at that time
  NearestFeatures nearest;  ///< its distance is within (0, touch_tolerance_m]
};

/// Distance at which two surfaces count as touching: 1e-5 of the smaller size, a tenth of the study's stated accuracy.
double touch_tolerance_m(const OracleMesh& a, const OracleMesh& b);

/// Finds when two flights first come within the tolerance, by conservative advancement (Mirtich 1996). No point of a
/// body moves faster than the speed of its centre plus spin times radius, so it never misses a contact. Any thread.
FirstTouch first_touch(const OracleMesh& a, const Flight& flight_a, const OracleMesh& b, const Flight& flight_b,
                       double horizon_s);

}  // namespace poise::oracle
