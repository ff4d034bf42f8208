// SPDX-License-Identifier: MIT
#include "scene/run/time_priors.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

io::TimePriorsKey some_key() { return {"a processor, a system", 2, 2, "tbb", "fitted", 0.01}; }

scheduler::TimePriors some_priors() {
  scheduler::TimePriors priors;
  priors.tail_us = {1, 2, 3.25, 4, 5, 6, 7, 8, 9};
  priors.head_us = {7, 6, 5, 4, 3, 2, 0.1 + 0.2};
  priors.log_quantile = 0.375;
  priors.spread = 0.125;
  priors.unit_cost_ns = 33;
  priors.frames = 600;
  return priors;
}

void replace(const std::string& file, const std::string& from, const std::string& to) {
  std::string text = contents(file);
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, from.size(), to);
  std::ofstream(file, std::ios::trunc) << text;
}

TEST(TimePriors, ComeBackAsTheyWereToTheBit) {
  const TemporaryFolder folder;
  const std::filesystem::path inside = folder.file("made/when/missing");
  EXPECT_FALSE(io::read_time_priors(inside, some_key()));
  ASSERT_TRUE(io::write_time_priors(inside, some_key(), some_priors()));
  const auto read = io::read_time_priors(inside, some_key());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->tail_us, some_priors().tail_us);
  EXPECT_EQ(read->head_us, some_priors().head_us);
  EXPECT_EQ(read->log_quantile, 0.375);
  EXPECT_EQ(read->spread, 0.125);
  EXPECT_EQ(read->unit_cost_ns, 33);
  EXPECT_EQ(read->frames, 600U);
}

TEST(TimePriors, AreThoseOfOneMachineAndOneWayToRun) {
  const TemporaryFolder folder;
  const std::filesystem::path inside = folder.file("");
  ASSERT_TRUE(io::write_time_priors(inside, some_key(), some_priors()));
  for (int field = 0; field < 6; ++field) {
    io::TimePriorsKey other = some_key();
    if (field == 0) other.machine = "another";
    if (field == 1) other.cores = 4;
    if (field == 2) other.threads = 1;
    if (field == 3) other.executor = "serial";
    if (field == 4) other.contact = "wrench";
    if (field == 5) other.alpha = 0.001;
    EXPECT_FALSE(io::read_time_priors(inside, other)) << field;
    // Also if its file was copied to the path of the other key.
    std::filesystem::copy_file(io::time_priors_file(inside, some_key()), io::time_priors_file(inside, other));
    EXPECT_FALSE(io::read_time_priors(inside, other)) << field;
  }
}

TEST(TimePriors, ThatAreDamagedOrSenselessAreNotUsed) {
  const TemporaryFolder folder;
  const std::filesystem::path inside = folder.file("");
  const std::string file = io::time_priors_file(inside, some_key()).string();
  const std::pair<const char*, const char*> damages[] = {{"\"frames\": 600", "\"frames\": 0"},
                                                         {"\"spread\": 0.125", "\"spread\": -1"},
                                                         {"\"log_quantile\": 0.375", "\"log_quantile\": 9"},
                                                         {"\"unit_cost_ns\": 33.0", "\"unit_cost_ns\": \"x\""},
                                                         {"3.25", "-3.25"},
                                                         {"3.25", "1e300"},
                                                         {"3.25,", ""},
                                                         {"poise.times/2", "poise.times/1"},
                                                         {"{", "["}};
  for (const auto& [from, to] : damages) {
    ASSERT_TRUE(io::write_time_priors(inside, some_key(), some_priors()));
    ASSERT_TRUE(io::read_time_priors(inside, some_key()));
    replace(file, from, to);
    EXPECT_FALSE(io::read_time_priors(inside, some_key())) << from << " -> " << to;
  }
  const std::string whole = contents(file);
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    std::ofstream(file, std::ios::trunc) << whole.substr(0, length);
    EXPECT_FALSE(io::read_time_priors(inside, some_key())) << length;
  }
}

TEST(TimePriors, OfNoFramesOrForNoFolderAreNotKept) {
  const TemporaryFolder folder;
  EXPECT_FALSE(io::write_time_priors({}, some_key(), some_priors()));
  EXPECT_FALSE(io::write_time_priors(folder.file(""), some_key(), {}));
  EXPECT_FALSE(std::filesystem::exists(io::time_priors_file(folder.file(""), some_key())));
}

}  // namespace
}  // namespace poise::testing
