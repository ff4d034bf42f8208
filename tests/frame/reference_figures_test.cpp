// SPDX-License-Identifier: MIT
#include "verify/reference_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "scene/run/reference_run.h"

namespace poise::simulation {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

View looking_along_x() {
  View view;
  view.present = true;
  view.position_m = Vec3(1, 2, 3);
  view.vertical_fov_rad = 60 * kDegree;
  view.aspect = 1;
  return view;
}

ComparedBody body(double dv, double reference_dv, double weight = 1) {
  ComparedBody compared;
  compared.dv_mps = Vec3(dv, 0, 0);
  compared.reference_dv_mps = Vec3(reference_dv, 0, 0);
  compared.weight = weight;
  return compared;
}

ComparedPair pair_of(double run_ns, double reference_ns, double gap_m = 0, double gap_px = 0) {
  ComparedPair pair;
  pair.run_ns = run_ns;
  pair.reference_ns = reference_ns;
  pair.gap_m = gap_m;
  pair.gap_px = gap_px;
  return pair;
}

TEST(JudgingWeight, IsOneForALargeBodyThatTheGazeIsOn) {
  const View view = looking_along_x();
  EXPECT_NEAR(error_weight(view, Vec3(11, 2, 3), 1, false), 1, 1e-12);
  EXPECT_NEAR(error_weight(view, Vec3(11, 2, 3), 1, true), 0.25, 1e-12);
}

TEST(JudgingWeight, FallsWithTheSquareOfAnAngleBelowOneDegree) {
  const View view = looking_along_x();
  // Half a degree of angular size: radius = distance sin(a quarter of a degree).
  const double radius = 100 * std::sin(0.25 * kDegree);
  EXPECT_NEAR(error_weight(view, Vec3(101, 2, 3), radius, false), 0.25, 1e-12);
  EXPECT_NEAR(error_weight(view, Vec3(101, 2, 3), 4 * radius, false), 1, 1e-12);
}

TEST(JudgingWeight, FallsWithTheAngleFromTheGaze) {
  View view = looking_along_x();
  view.gaze = Vec3(std::cos(5 * kDegree), std::sin(5 * kDegree), 0);
  EXPECT_NEAR(error_weight(view, Vec3(11, 2, 3), 1, false), 1 / std::pow(1 + 5 / 2.5, 2), 1e-12);
  EXPECT_NEAR(error_weight(view, Vec3(11, 2, 3), 1, true), 0.25 / std::pow(1 + 5 / 2.5, 2), 1e-12);
}

TEST(JudgingWeight, IsATwentiethOutsideTheFrustumHiddenOrNot) {
  const View view = looking_along_x();
  const Vec3 behind(-9, 2, 3);
  const double expected = 0.05 / std::pow(1 + 180 / 2.5, 2);
  EXPECT_NEAR(error_weight(view, behind, 1, false), expected, 1e-15);
  EXPECT_NEAR(error_weight(view, behind, 1, true), expected, 1e-15);
}

TEST(JudgingWeight, IsOneWithoutAView) { EXPECT_EQ(error_weight(View{}, Vec3(1, 2, 3), 0.1, true), 1); }

TEST(LengthInPixels, FillsThePictureWhereItFillsTheView) {
  const View view = looking_along_x();
  const double height_m = 2 * 10 * std::tan(30 * kDegree);
  EXPECT_NEAR(length_px(view, Vec3(11, 2, 3), height_m), 1080, 1e-9);
  EXPECT_NEAR(length_px(view, Vec3(21, 2, 3), height_m), 540, 1e-9);
}

TEST(CompareFrame, ReckonsTheThreeErrorsByHand) {
  std::vector<ComparedBody> bodies = {body(3, 2, 1.0), body(-1, -4, 0.25)};
  bodies[1].dw_radps = Vec3(0, 0, 2);
  bodies[1].reference_dw_radps = Vec3(0, 0, 6);
  bodies[1].inertia_per_mass_m2 = Vec3(9, 9, 0.5).asDiagonal();
  // eps^2 = 1 and 9 + 16 * 0.5 = 17; |du*|^2 = 4 and 16 + 36 * 0.5 = 34.
  const ReferenceFigures figures = compare_frames(bodies, {}, true);
  EXPECT_EQ(figures.bodies_touched, 2U);
  EXPECT_NEAR(figures.e_mps.value(), std::sqrt(18 / 2.0), 1e-15);
  EXPECT_NEAR(figures.change_mps.value(), std::sqrt(38 / 2.0), 1e-14);
  EXPECT_NEAR(figures.e_rel.value(), std::sqrt(18.0 / 38), 1e-15);
  EXPECT_NEAR(figures.e_seen_mps.value(), std::sqrt((1 + 0.25 * 17) / 1.25), 1e-15);
}

TEST(CompareFrame, LeavesEmptyWhatNothingTouchedOrMoved) {
  const ReferenceFigures nothing = compare_frames({}, {}, true);
  EXPECT_FALSE(nothing.e_mps || nothing.e_rel || nothing.e_seen_mps || nothing.change_mps);
  EXPECT_FALSE(nothing.false_rate || nothing.missed_rate || nothing.gap_mean_m || nothing.gap_max_px);
  const std::vector<ComparedBody> at_rest = {body(1, 0)};
  EXPECT_EQ(compare_frames(at_rest, {}, true).e_mps.value(), 1);
  EXPECT_FALSE(compare_frames(at_rest, {}, true).e_rel);
}

TEST(CompareFrame, CountsFalseAndMissedContacts) {
  const std::vector<ComparedPair> pairs = {pair_of(1, 1), pair_of(2, 0), pair_of(0.5, 0), pair_of(0, 4), pair_of(0, 0),
                                           // An impulse below the tolerance of the reference counts as 0.
                                           pair_of(1e-12, 1), pair_of(1, 1e-12)};
  const ReferenceFigures figures = compare_frames({}, pairs, false);
  EXPECT_EQ(figures.run_contacts, 4U);
  EXPECT_EQ(figures.reference_contacts, 3U);
  EXPECT_EQ(figures.false_contacts, 3U);
  EXPECT_EQ(figures.missed_contacts, 2U);
  EXPECT_NEAR(figures.false_rate.value(), 3.0 / 4, 1e-15);
  EXPECT_NEAR(figures.missed_rate.value(), 2.0 / 3, 1e-15);
}

TEST(CompareFrame, TakesGapsOverContactsOfTheRunThatAreApart) {
  const std::vector<ComparedPair> pairs = {pair_of(1, 0, 0.25, 8), pair_of(1, 1, 0.75, 2), pair_of(1, 1, 0, 0),
                                           pair_of(0, 1, 9, 900)};
  const ReferenceFigures figures = compare_frames({}, pairs, true);
  EXPECT_EQ(figures.contacts_apart, 2U);
  EXPECT_EQ(figures.gap_mean_m.value(), 0.5);
  EXPECT_EQ(figures.gap_max_m.value(), 0.75);
  EXPECT_EQ(figures.gap_mean_px.value(), 5);
  EXPECT_EQ(figures.gap_max_px.value(), 8);
  EXPECT_FALSE(compare_frames({}, pairs, false).gap_mean_px);
}

TEST(ReferenceRunFigures, PutsTogetherTheConvergedFramesThatDefineAFigure) {
  std::vector<ReferenceFigures> frames(4);
  for (ReferenceFigures& frame : frames) frame.converged = true;
  frames[1].converged = false;
  frames[0].e_mps = 3;
  frames[1].e_mps = 1;
  frames[3].e_mps = 2;
  frames[2].gap_max_m = 0.004;
  frames[0].run_contacts = 8;
  frames[0].false_contacts = 1;
  frames[1].run_contacts = 2;
  frames[1].false_contacts = 2;
  frames[1].iterations = 7;
  const ReferenceRunFigures figures = reference_run_figures(frames);
  EXPECT_EQ(figures.frames, 4U);
  EXPECT_EQ(figures.not_converged, 1U);
  EXPECT_EQ(figures.e_mps.value().p50, 2);
  EXPECT_EQ(figures.e_mps.value().max, 3);
  EXPECT_EQ(figures.gap_max_mm.value().p50, 4);
  EXPECT_EQ(figures.false_share.value(), 0.125);
  EXPECT_EQ(figures.iterations.value().max, 7);
  EXPECT_FALSE(figures.e_rel || figures.missed_share || figures.gap_mean_px);
  EXPECT_FALSE(reference_run_figures({}).e_mps || reference_run_figures({}).time_ms);
}

}  // namespace
}  // namespace poise::simulation
