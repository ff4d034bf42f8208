// SPDX-License-Identifier: MIT
#include "verify/contact_noise.h"

#include <bit>

#include "geometry/primitives/random.h"

namespace poise::simulation {
namespace {

class Errors {
 public:
  Errors(const ContactNoise& noise, geometry::Random random) : noise_(noise), random_(random) {}

  [[nodiscard]] double of_separation_m() { return noise_.separation_m * random_.symmetric(); }
  [[nodiscard]] Vec3 of_point_m() { return noise_.point_m * vector(); }
  [[nodiscard]] Vec3 with_error(const Vec3& normal) {
    const Vec3 turned = normal + noise_.normal_rad * vector();
    return turned.isZero(0) ? normal : turned.normalized();
  }

 private:
  // In separate statements: the order of evaluation of arguments differs between compilers.
  Vec3 vector() {
    const double x = random_.symmetric();
    const double y = random_.symmetric();
    const double z = random_.symmetric();
    return {x, y, z};
  }

  const ContactNoise& noise_;
  geometry::Random random_;
};

}  // namespace

void add_noise(const ContactNoise& noise, const PredictedMotion& motion, const PairTable& table,
               CompletedLevels& levels) {
  if (!noise.any()) return;
  for (std::size_t i = 0; i < table.size(); ++i) {
    PairProgress& progress = levels.progress[i];
    if (progress.level.level == 0 || progress.apart() || progress.found == 0) continue;
    FoundContact& found = levels.found.of(progress);
    if (!found.contact.present) continue;
    const ActivePair& pair = table.pairs[i];
    collision::PairContact& contact = found.contact;
    Errors errors(noise, geometry::Random::of(std::bit_cast<std::uint64_t>(contact.estimated_separation_m),
                                              (std::uint64_t{pair.a} << 32U) | pair.b));
    const double more_m = errors.of_separation_m();
    contact.estimated_separation_m += more_m;
    contact.certain_separation_m += more_m;
    contact.arm_m += errors.of_point_m();
    contact.direction = errors.with_error(contact.direction);
    const Vec3 a_to_b_m = motion.poses[pair.b].position_m - motion.poses[pair.a].position_m;
    contact.moment_a_m = contact.arm_m.cross(contact.direction);
    contact.moment_b_m = (contact.arm_m - a_to_b_m).cross(contact.direction);
    for (collision::ManifoldPoint& point : levels.found.points_of(found)) {
      const double point_more_m = errors.of_separation_m();
      point.gap_m += point_more_m;
      point.certain_separation_m += point_more_m;
      point.point_m += errors.of_point_m();
      point.normal = errors.with_error(point.normal);
    }
  }
}

}  // namespace poise::simulation
