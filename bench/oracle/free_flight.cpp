// SPDX-License-Identifier: MIT
#include "oracle/free_flight.h"

#include <algorithm>
#include <cmath>

namespace poise::oracle {
namespace {

constexpr double kTolerance = 1e-5;
constexpr int kMostSteps = 5000;

}  // namespace

Placed Flight::at(double time_s) const {
  const double rate = spin_radps.norm();
  Placed placed{start.position_m + time_s * velocity_mps, start.orientation};
  if (rate > 0) {
    const Vec3 axis = std::sin(0.5 * rate * time_s) / rate * spin_radps;
    placed.orientation =
        (Quat(std::cos(0.5 * rate * time_s), axis.x(), axis.y(), axis.z()) * start.orientation).normalized();
  }
  return placed;
}

double touch_tolerance_m(const OracleMesh& a, const OracleMesh& b) {
  return kTolerance * std::min(a.size_m(), b.size_m());
}

FirstTouch first_touch(const OracleMesh& a, const Flight& flight_a, const OracleMesh& b, const Flight& flight_b,
                       double horizon_s) {
  const double tolerance = touch_tolerance_m(a, b);
  const double fastest = (flight_b.velocity_mps - flight_a.velocity_mps).norm() +
                         flight_a.spin_radps.norm() * a.radius_m() + flight_b.spin_radps.norm() * b.radius_m();
  FirstTouch touch;
  for (int step = 0; step < kMostSteps; ++step) {
    touch.a = flight_a.at(touch.time_s);
    touch.b = flight_b.at(touch.time_s);
    const double distance = a.distance_m(touch.a, b, touch.b);
    if (distance <= tolerance) {
      touch.outcome = step == 0 ? FlightOutcome::StartsTouching : FlightOutcome::Touch;
      touch.nearest = a.nearest(touch.a, b, touch.b);
      return touch;
    }
    if (!(fastest > 0)) return touch;
    // Half the tolerance remains even if the surfaces close at full speed.
    touch.time_s += (distance - 0.5 * tolerance) / fastest;
    if (touch.time_s > horizon_s) return touch;
  }
  touch.outcome = FlightOutcome::Undecided;
  return touch;
}

}  // namespace poise::oracle
