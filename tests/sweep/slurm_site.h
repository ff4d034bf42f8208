// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "scene/temporary_folder.h"

namespace poise::testing {

/// A Slurm of this machine alone for one test: its daemons, key and ports are its own (slurm_site.sh). MaxArraySize is
/// 12.
class SlurmSite : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;
  /// Runs a Slurm command and returns what it prints.
  std::string ask(const std::string& line) const;
  /// How many of the daemons run that Slurm has for each step of a job.
  [[nodiscard]] std::size_t step_daemons() const;
  /// The number of the job array whose folder this is.
  static std::string job_of(const std::string& folder);

 private:
  [[nodiscard]] std::string site(const std::string& action) const;

  TemporaryFolder folder_;
  bool started_ = false;
};

}  // namespace poise::testing
