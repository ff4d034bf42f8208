// SPDX-License-Identifier: MIT
#include "solver/iterations/impulse_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "collision/instruction_sets.h"
#include "solver/iterations/energy_lanes.h"

namespace poise::solver {
namespace {

class Numbers {
 public:
  explicit Numbers(unsigned seed) : random_(seed) {}
  double next() { return number_(random_); }
  std::vector<double> list(std::size_t count) {
    std::vector<double> made(count);
    for (double& value : made) value = next();
    return made;
  }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> number_{-1, 1};
};

// Five of eight lanes are in use, with three contact points each; one of them has no mass.
struct Block {
  static constexpr std::size_t kPoints = 3, kCount = 5;
  ContactBlock block;
  PairLanes<double> pairs;
  std::vector<PointLanes<double>> points = std::vector<PointLanes<double>>(kPoints);
  std::vector<double> roots, numbers;

  explicit Block(bool frictional) {
    Numbers random(1);
    block.count = kCount;
    block.manifold_points = kPoints;
    block.frictional = frictional;
    for (double& friction : pairs.friction) friction = 0.3 + std::abs(random.next());
    for (PointLanes<double>& point : points) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        Vec3 normal(random.next(), random.next(), random.next());
        normal.normalize();
        point.impulse[lane] = std::abs(random.next());
        for (Eigen::Index k = 0; k < 3; ++k) {
          point.normal[k][lane] = normal[k];
          point.friction_impulse[k][lane] = random.next();
        }
      }
    }
    roots = random.list(impulse_numbers(block) + kNumbersBeyond);
    for (double& root : roots) root = root < -0.6 ? 0 : std::abs(root) + 0.1;
    numbers = random.list(roots.size());
  }
  /// Where the numbers of a lane of a contact point begin.
  [[nodiscard]] std::size_t at(std::size_t point, std::size_t lane) const {
    return (point * kCount + lane) * (block.frictional ? 4 : 1);
  }
  [[nodiscard]] std::vector<double> impulses_of(std::size_t p, std::size_t lane) const {
    const PointLanes<double>& point = points[p];
    if (!block.frictional) return {point.impulse[lane]};
    return {point.impulse[lane], point.friction_impulse[0][lane], point.friction_impulse[1][lane],
            point.friction_impulse[2][lane]};
  }
};

std::vector<double> part(const std::vector<double>& of, std::size_t begin, std::size_t count) {
  const auto at = of.begin() + static_cast<std::ptrdiff_t>(begin);
  return {at, at + static_cast<std::ptrdiff_t>(count)};
}

// What impulses become of numbers that were extrapolated, one lane after another.
std::vector<double> clamped(const Block& made, std::size_t p, std::size_t lane) {
  const auto number = [&](std::size_t k) {
    const double root = made.roots[made.at(p, lane) + k];
    return root > 0 ? made.numbers[made.at(p, lane) + k] / root : 0.0;
  };
  const double along = std::max(0.0, number(0));
  if (!made.block.frictional) return {along};
  const PointLanes<double>& point = made.points[p];
  const Vec3 normal(point.normal[0][lane], point.normal[1][lane], point.normal[2][lane]);
  Vec3 across(number(1), number(2), number(3));
  across -= across.dot(normal) * normal;
  const double most = made.pairs.friction[lane] * along;
  if (across.norm() > most) across *= most / across.norm();
  return {along, across.x(), across.y(), across.z()};
}

class ImpulseLanes : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(WithFrictionAndWithout, ImpulseLanes, testing::Bool());

TEST_P(ImpulseLanes, AreListedTimesTheirRoots) {
  const int sets = collision::on_every_instruction_set([&](const char* name) {
    const Block made(GetParam());
    std::vector<double> listed(made.numbers.size(), 7);
    list_impulses(made.block, made.points, made.roots.data(), listed.data());
    for (std::size_t p = 0; p < Block::kPoints; ++p) {
      for (std::size_t lane = 0; lane < Block::kCount; ++lane) {
        std::vector<double> expected = made.impulses_of(p, lane);
        for (std::size_t k = 0; k < expected.size(); ++k) expected[k] *= made.roots[made.at(p, lane) + k];
        EXPECT_EQ(part(listed, made.at(p, lane), expected.size()), expected) << name;
      }
    }
    EXPECT_EQ(part(listed, impulse_numbers(made.block), kNumbersBeyond), std::vector<double>(kNumbersBeyond, 7))
        << name << ": nothing is written beyond";
  });
  EXPECT_GE(sets, 1);
}

TEST_P(ImpulseLanes, ThatWereExtrapolatedPressAndStayWithinTheFrictionCone) {
  const int sets = collision::on_every_instruction_set([&](const char* name) {
    const Block old(GetParam());
    Block made = old;
    std::vector<double> before(made.numbers.size(), 7);
    change_impulses(made.block, made.pairs, made.points, made.roots.data(), made.numbers.data(), before.data());
    for (std::size_t p = 0; p < Block::kPoints; ++p) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::vector<double> had = old.impulses_of(p, lane);
        if (lane >= Block::kCount) {
          EXPECT_EQ(made.impulses_of(p, lane), had) << name << ": a lane that is not in use";
          continue;
        }
        const std::vector<double> wanted = clamped(old, p, lane);
        EXPECT_EQ(part(made.numbers, made.at(p, lane), wanted.size()), wanted) << name;
        EXPECT_EQ(part(before, made.at(p, lane), wanted.size()), had) << name;
        std::vector<double> change = wanted;
        for (std::size_t k = 0; k < change.size(); ++k) change[k] -= had[k];
        EXPECT_EQ(made.impulses_of(p, lane), change) << name << ": what the bodies are given";
      }
    }
    const std::size_t count = impulse_numbers(made.block);
    EXPECT_EQ(part(before, count, kNumbersBeyond), std::vector<double>(kNumbersBeyond, 7)) << name;
    EXPECT_EQ(part(made.numbers, count, kNumbersBeyond), part(old.numbers, count, kNumbersBeyond)) << name;
    // And back, to the bit.
    std::vector<double> listed(before.size(), 7);
    std::vector<double> expected = listed;
    set_impulses(made.block, made.points, before.data(), made.roots.data(), listed.data());
    list_impulses(old.block, old.points, old.roots.data(), expected.data());
    EXPECT_EQ(listed, expected) << name;
    for (std::size_t p = 0; p < Block::kPoints; ++p) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) EXPECT_EQ(made.impulses_of(p, lane), old.impulses_of(p, lane));
    }
  });
  EXPECT_GE(sets, 1);
}

TEST(EnergyLanes, SumBodyAfterBodyOnEveryInstructionSet) {
  constexpr std::size_t kBodies = 11;
  Numbers random(2);
  std::vector<MotionChange<double>> changes(kBodies + 3);
  std::vector<BodyEnergies> bodies(2);
  double expected_j = 0;
  const auto vector = [&] { return Vec3(random.next(), random.next(), random.next()); };
  for (std::size_t i = 0; i < kBodies; ++i) {
    BodyEnergies& lanes = bodies[i / kLanes];
    const std::size_t lane = lanes.count++;
    const std::size_t name = kBodies + 2 - i;
    const Vec3 v = vector();
    const Vec3 w = vector();
    const double kg = random.next() + 2;
    Mat3 inertia_kgm2;
    inertia_kgm2 << vector(), vector(), vector();
    MotionChange<double>& change = changes[name];
    lanes.name[lane] = static_cast<std::uint32_t>(name);
    lanes.kg[lane] = kg;
    for (Eigen::Index k = 0; k < 3; ++k) {
      lanes.velocity_mps[k][lane] = v[k];
      lanes.spin_radps[k][lane] = w[k];
      change.v[k] = random.next();
      change.w[k] = random.next();
      for (Eigen::Index row = 0; row < 3; ++row) lanes.inertia_kgm2[k][row][lane] = inertia_kgm2(row, k);
    }
    const Vec3 now_v = v + Vec3(change.v[0], change.v[1], change.v[2]);
    const Vec3 now_w = w + Vec3(change.w[0], change.w[1], change.w[2]);
    expected_j += 0.5 * (kg * now_v.dot(now_v) + now_w.dot(inertia_kgm2 * now_w));
  }
  const int sets = collision::on_every_instruction_set(
      [&](const char* name) { EXPECT_EQ(kinetic_j(bodies, changes.data()), expected_j) << name; });
  EXPECT_GE(sets, 1);
}

}  // namespace
}  // namespace poise::solver
