// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <thread>

#include "frame/scenes.h"

namespace poise {
namespace {

using Pair = std::pair<BodyId, BodyId>;

WorldSettings heavy() {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.threads = 1;
  return settings;
}

std::set<Pair> pairs_of(std::span<const Contact> contacts) {
  std::set<Pair> pairs;
  for (const Contact& contact : contacts) pairs.emplace(contact.a, contact.b);
  return pairs;
}

/// Updates the set of touching pairs by the events.
void follow(std::set<Pair>& touching, std::span<const ContactEvent> events) {
  for (const ContactEvent& event : events) {
    const Pair pair(event.a, event.b);
    if (event.kind == ContactEvent::Kind::End) {
      EXPECT_EQ(touching.erase(pair), 1U) << event.a.slot << " " << event.b.slot;
    } else {
      EXPECT_TRUE(touching.insert(pair).second) << event.a.slot << " " << event.b.slot;
    }
  }
}

TEST(Contacts, AreThePairsThatEventsSayTouch) {
  for (const bool backtracking : {false, true}) {
    Stage stage(heavy());
    stage.jacks(100, 8);
    std::set<Pair> touching;
    std::size_t listed = 0;
    StepInput input;
    input.backtracking = backtracking;
    for (int frame = 0; frame < 150; ++frame) {
      const FrameReport report = stage.world.step(input);
      follow(touching, stage.world.contact_events());
      EXPECT_EQ(pairs_of(stage.world.contacts()), touching) << "frame " << frame;
      EXPECT_TRUE(std::ranges::is_sorted(stage.world.contacts(), {},
                                         [](const Contact& c) { return std::pair(c.a.slot, c.b.slot); }));
      for (const Contact& contact : stage.world.contacts()) {
        // For separated surfaces only an impulse makes a contact.
        if (contact.gap_m > 0.01) {
          EXPECT_GT(contact.impulse_ns.norm(), 0) << contact.gap_m;
        }
      }
      listed += stage.world.contacts().size();
      EXPECT_LE(stage.world.contacts().size(), report.contact_pairs + report.swept_hits);
    }
    EXPECT_GT(listed, 1000U);
  }
}

TEST(Contacts, OfWhatIsApartAndGivesNoImpulseAreNone) {
  Stage stage(heavy());
  stage.plane(Vec3::UnitZ(), 0);
  // Fast enough sideways to be a candidate, 0.17 m above the floor.
  stage.add(stage.ball(0.5), Vec3(0, 0, 0.67), Vec3(12, 0, 0));
  const FrameReport report = stage.world.step({});
  EXPECT_GT(report.candidate_pairs, 0U);
  EXPECT_TRUE(stage.world.contacts().empty());
  EXPECT_TRUE(stage.world.contact_events().empty());
}

TEST(Contacts, OfARemovedBodyEndWithTheNextStep) {
  Stage stage(heavy(), 0);
  const BodyId floor = stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  const BodyId left = stage.add(ball, Vec3(0, 0, 0.5));
  const BodyId right = stage.add(ball, Vec3(3, 0, 0.5));
  for (int frame = 0; frame < 10; ++frame) stage.world.step({});
  ASSERT_EQ(stage.world.contacts().size(), 2U);
  ASSERT_TRUE(stage.world.remove_body(left));
  ASSERT_EQ(stage.world.contacts().size(), 1U);
  EXPECT_EQ(stage.world.contacts()[0].b, right);
  // Before the step the slot is reused, and the new body is removed as well.
  const BodyId brief = stage.add(ball, Vec3(0, 0, 0.5));
  EXPECT_EQ(brief.slot, left.slot);
  ASSERT_TRUE(stage.world.remove_body(brief));
  EXPECT_EQ(stage.world.contacts().size(), 1U);
  stage.world.step({});
  ASSERT_EQ(stage.world.contact_events().size(), 1U);
  const ContactEvent& end = stage.world.contact_events()[0];
  EXPECT_EQ(end.kind, ContactEvent::Kind::End);
  EXPECT_EQ(end.a, floor);
  EXPECT_EQ(end.b, left);
  stage.world.step({});
  EXPECT_TRUE(stage.world.contact_events().empty());
}

TEST(Contacts, FollowEventsWhileBodiesComeAndGo) {
  WorldSettings settings = heavy();
  settings.sleeping = true;
  Stage stage(settings);
  stage.jacks(60, 6);
  std::set<Pair> touching;
  for (int frame = 0; frame < 200; ++frame) {
    stage.world.step({});
    follow(touching, stage.world.contact_events());
    for (const Contact& contact : stage.world.contacts()) EXPECT_TRUE(touching.contains({contact.a, contact.b}));
    if (frame % 4 == 3) {
      const auto at = static_cast<std::size_t>(frame) / 4;
      ASSERT_TRUE(stage.world.remove_body(stage.bodies[at]));
    }
  }
  stage.world.step({});
  follow(touching, stage.world.contact_events());
  EXPECT_FALSE(touching.empty());
  for (const Pair& pair : touching)
    EXPECT_TRUE(stage.world.contains(pair.first) && stage.world.contains(pair.second)) << "its end was never told";
}

TEST(Contacts, AreListedForManyThreadsAtOnce) {
  Stage stage(heavy());
  stage.jacks(100, 8);
  for (int frame = 0; frame < 40; ++frame) {
    stage.world.step({});
    std::array<const Contact*, 4> first{};
    std::array<std::size_t, 4> count{};
    {
      std::vector<std::jthread> threads;
      for (std::size_t t = 0; t < first.size(); ++t) {
        threads.emplace_back([&, t] {
          const std::span<const Contact> contacts = stage.world.contacts();
          first[t] = contacts.data();
          count[t] = contacts.size();
        });
      }
    }
    for (std::size_t t = 1; t < first.size(); ++t) {
      EXPECT_EQ(first[t], first[0]);
      EXPECT_EQ(count[t], count[0]);
    }
  }
}

TEST(Contacts, OfAWorldThatWasNeverSteppedAreNone) {
  Stage stage(heavy());
  EXPECT_TRUE(stage.world.contacts().empty());
  const BodyId body = stage.add(stage.ball(0.5), Vec3::Zero());
  ASSERT_TRUE(stage.world.remove_body(body));
  EXPECT_TRUE(stage.world.contacts().empty());
}

// Two balls that nearly touch, so that a step takes them for a contact, and what is told of it when one is gone.
TEST(Contacts, AreNoneOfABodyThatIsGone) {
  for (const ContactModel model : {ContactModel::Paper, ContactModel::Wrench, ContactModel::Fitted}) {
    for (const bool replaced : {false, true}) {
      WorldSettings settings;
      settings.threads = 1;
      settings.contact = model;
      Stage stage(settings);
      const ShapeId ball = stage.ball(0.5);
      const BodyId one = stage.add(ball, Vec3::Zero());
      stage.add(ball, Vec3(1.0005, 0, 0));
      ASSERT_EQ(stage.world.step(step_of(1.0 / 60)).contact_pairs, 1U);
      ASSERT_TRUE(stage.world.remove_body(one).ok());
      if (replaced) stage.plane(Vec3::UnitZ(), -5);
      EXPECT_TRUE(stage.world.contacts().empty());
    }
  }
}

}  // namespace
}  // namespace poise
