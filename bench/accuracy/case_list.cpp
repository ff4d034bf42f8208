// SPDX-License-Identifier: MIT
#include <array>

#include "accuracy/accuracy_case.h"
#include "accuracy/equal_shares.h"
#include "accuracy/flights.h"
#include "accuracy/friction.h"
#include "accuracy/hard_cases.h"
#include "accuracy/impacts.h"
#include "accuracy/level_changes.h"
#include "accuracy/refusals.h"
#include "accuracy/scene_cases.h"

namespace poise::accuracy {
namespace {

constexpr std::array kCases = {
    Case{"two spheres", "the impulse (1 + e) v m_a m_b / (m_a + m_b) along the line of centres", two_spheres},
    Case{"momenta of a cloud", "sums of momentum and angular momentum stay", cloud_momenta},
    Case{"energy of an impact", "e = 1: kinetic energy stays", impact_energy},
    Case{"free flight", "x0 + v t + g t^2 / 2", free_flight},
    Case{"spinning top", "Jacobi's functions", spinning_top},
    Case{"dropped ball", "rest after sqrt(2 h / g) (1 + e) / (1 - e)", dropped_ball},
    Case{"five balls", "(1, 0, 0, 0, 0) becomes (0, 0, 0, 0, 1)", five_balls},
    Case{"sliding box", "v^2 / (2 mu g)", sliding_box},
    Case{"sliding balls", "v^2 / (2 mu g)", sliding_balls},
    Case{"slope, box on plane", "atan(mu)", slope_box},
    Case{"slope, box on box", "atan(mu)", slope_box_on_box},
    Case{"slope, balls on plane", "atan(mu)", slope_balls},
    Case{"tipping box", "atan(width / height)", tipping_box},
    Case{"rolling ball", "5/7 g sin(angle)", rolling_ball},
    Case{"skidding ball", "5/7 of its speed; g (sin - mu cos), 5/2 mu g cos / r", skidding_ball},
    Case{"spinning rings", "angular momentum stays", spinning_rings},
    Case{"two gases", "equal mean energies", two_gases},
    Case{"bouncing 7 x 7", "energy stays", bouncing_balls},
    Case{"666", "no overlap", falling_cube},
    Case{"stack of 5 spheres", "stands", stack_of_spheres},
    Case{"stack of 10 boxes", "stands", stack_of_boxes},
    Case{"wall of 50 bricks", "stands", wall_of_bricks},
    Case{"arch of 11 stones", "stands", arch},
    Case{"card house", "stands", card_house},
    Case{"400 : 1 on top", "stands", heavy_on_top},
    Case{"chain 1000 : 1", "stands", chain_of_masses},
    Case{"pile of 1,000", "lies", mixed_pile},
    Case{"bowl of spheres", "lies", bowl_of_spheres},
    Case{"levels change, jacks", "lies as at full levels", jacks_change_levels},
    Case{"levels change, jacks, friction", "lies as at full levels", jacks_change_levels_with_friction},
    Case{"levels change, meshes", "lies as at full levels", meshes_change_levels},
    Case{"levels change, meshes, friction", "lies as at full levels", meshes_change_levels_with_friction},
    Case{"hard: coinciding centres", "sane", coinciding_centres},
    Case{"hard: equal positions", "sane", equal_positions},
    Case{"hard: mass ratio 1e6", "sane", mass_ratios},
    Case{"hard: towers of random masses", "sane", random_masses},
    Case{"hard: needles and plates", "sane", needles_and_plates},
    Case{"hard: 1 km/s", "sane", one_km_per_s},
    Case{"hard: 1e7 m away", "sane", far_from_origin},
    Case{"hard: spins of 1e4 rad/s", "sane", fast_spins},
    Case{"hard: spawned overlapping", "sane", overlapping_spawn},
    Case{"hard: a million impacts", "sane, and energy stays", million_impacts},
    Case{"hard: time steps", "sane", time_steps},
    Case{"hard: levels that flip", "sane", flipping_levels},
    Case{"hard: bad states", "refused", bad_states},
    Case{"bullet", "neither tunnels nor gains energy", bullet},
};

}  // namespace

std::span<const Case> all_cases() { return kCases; }

}  // namespace poise::accuracy
