// SPDX-License-Identifier: MIT
#include "sweep/slurm_array.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sweep/specs.h"

namespace poise::testing {
namespace {

TEST(SlurmScript, AsksForWhatATaskNeeds) {
  sweep::SlurmArray array;
  array.command = {"/opt/my poise/poise", "sweep", "--batch", "it's"};
  array.tasks = 40;
  array.cores = 2;
  array.task_limit_s = 90;
  const std::string script = sweep::slurm_script(array);
  for (const char* line : {"#!/bin/sh\n", "#SBATCH --array=0-39\n", "#SBATCH --cpus-per-task=2\n", "#SBATCH --time=3\n",
                           "#SBATCH --requeue\n", "--cpu-bind=cores",
                           "'/opt/my poise/poise' sweep --batch 'it'\\''s' --task \"$SLURM_ARRAY_TASK_ID\"\n"})
    EXPECT_NE(script.find(line), std::string::npos) << line << "\n" << script;
  EXPECT_EQ(script.find("--exclusive"), std::string::npos);
  array.exclusive = true;
  array.tasks_at_once = 5;
  EXPECT_NE(sweep::slurm_script(array).find("#SBATCH --exclusive\n"), std::string::npos);
  EXPECT_NE(sweep::slurm_script(array).find("#SBATCH --array=0-39%5\n"), std::string::npos);
}

TEST(SlurmAnswers, AreRead) {
  EXPECT_EQ(sweep::max_array_size("MaxArraySize            = 1001\nMaxJobCount = 10000"), 1001U);
  EXPECT_EQ(sweep::max_array_size("MaxJobCount = 10000"), std::nullopt);
  EXPECT_EQ(sweep::max_array_size("MaxArraySize"), std::nullopt);
  EXPECT_EQ(sweep::submitted_job("123\n"), 123U);
  EXPECT_EQ(sweep::submitted_job("123;cluster\n"), 123U);
  EXPECT_EQ(sweep::submitted_job("Submitted batch job 5\n"), std::nullopt);
  EXPECT_EQ(sweep::submitted_job(""), std::nullopt);
}

TEST(SlurmBatches, AreOneForEachNumberOfCoresWithinTheLimit) {
  nlohmann::ordered_json spec = small_spec();
  spec["axes"] = {{"threads", {2, 1}}, {"bodies", {10, 20, 30}}};
  const std::vector<sweep::Trial> trials =
      sweep::expand(spec_of(spec), small_scenes(), "build").value_or(std::vector<sweep::Trial>{});
  ASSERT_EQ(trials.size(), 24U);
  const std::vector<sweep::TrialBatch> batches = sweep::slurm_batches(trials, 5, true);
  ASSERT_EQ(batches.size(), 2U);
  std::size_t count = 0;
  for (const sweep::TrialBatch& batch : batches) {
    EXPECT_LE(batch.tasks(), 5U);
    EXPECT_TRUE(batch.exclusive);
    for (std::uint64_t task = 0; task < batch.tasks(); ++task) {
      for (const sweep::Trial& trial : batch.of_task(task)) {
        EXPECT_EQ(trial.cores, batch.trials[0].cores);
        ++count;
      }
    }
  }
  EXPECT_EQ(count, 24U);
  EXPECT_TRUE(sweep::slurm_batches({}, 5, false).empty());
}

}  // namespace
}  // namespace poise::testing
