// SPDX-License-Identifier: MIT
#include "sweep/slurm_site.h"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "sweep/sweep_runs.h"

namespace poise::testing {
namespace {

namespace fs = std::filesystem;

/// Runs a line of the shell, and returns its exit code.
int shell(const std::string& line) {
  const int status = std::system(line.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

void SlurmSite::SetUp() {
  const int started = shell(site("start") + " >'" + folder_.file("said") + "' 2>&1");
  if (started == 77) GTEST_SKIP() << "no Slurm: " << contents(folder_.file("said"));
  started_ = true;
  ASSERT_EQ(started, 0) << contents(folder_.file("said"));
  ::setenv("SLURM_CONF", folder_.file("slurm.conf").c_str(), 1);
}

void SlurmSite::TearDown() {
  if (!started_) return;
  if (HasFailure()) ADD_FAILURE() << "slurmctld: " << ask("tail -n 60 '" + folder_.file("slurmctld.log") + "'");
  EXPECT_EQ(shell(site("stop")), 0);
  for (const char* daemon : {"slurmctld", "slurmd", "munged"}) {
    const std::string id = contents(folder_.file(std::string(daemon) + ".pid"));
    // A process that has ended may still be in the list, until its parent has looked.
    const std::string status = contents("/proc/" + id.substr(0, id.find('\n')) + "/status");
    EXPECT_TRUE(id.empty() || status.empty() || says(status, "State:\tZ")) << daemon << " is left\n" << status;
  }
}

std::string SlurmSite::site(const std::string& action) const {
  return std::string(POISE_SOURCE_DIR) + "/tests/sweep/slurm_site.sh " + action + " '" + folder_.path().string() + "'";
}

std::string SlurmSite::ask(const std::string& line) const {
  shell(line + " >'" + folder_.file("answer") + "' 2>&1");
  return contents(folder_.file("answer"));
}

std::size_t SlurmSite::step_daemons() const {
  std::size_t count = 0;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc", none)) {
    // It writes its title over its environment, but it works in the folder of its log.
    const bool daemon = contents(entry.path() / "comm") == "slurmstepd\n";
    count += daemon && fs::read_symlink(entry.path() / "cwd", none) == folder_.path() ? 1U : 0U;
  }
  return count;
}

std::string SlurmSite::job_of(const std::string& folder) {
  const std::string job = contents(folder + "/job");
  return job.substr(0, job.find('\n'));
}

}  // namespace poise::testing
