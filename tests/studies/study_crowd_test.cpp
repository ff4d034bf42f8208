// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "studies/crowd_run.h"

namespace poise::testing {
namespace {

using app::CrowdErrors;
using nlohmann::json;

ReferenceFigures figures(double e_mps, double change_mps, std::size_t bodies) {
  ReferenceFigures made;
  made.e_mps = e_mps;
  made.change_mps = change_mps;
  made.e_rel = e_mps / change_mps;
  made.bodies_touched = bodies;
  made.run_contacts = 10;
  made.false_contacts = 1;
  made.reference_contacts = 20;
  made.missed_contacts = 4;
  return made;
}

TEST(CrowdErrors, CountEachFrameOnceAndEachBodyOnce) {
  CrowdErrors errors;
  EXPECT_TRUE(std::isnan(errors.median()));
  EXPECT_TRUE(std::isnan(errors.false_share()));
  errors.add(figures(1, 2, 1));
  errors.add(figures(3, 4, 3));
  EXPECT_EQ(errors.frames(), 2U);
  EXPECT_DOUBLE_EQ(errors.median(), 0.5);
  EXPECT_DOUBLE_EQ(errors.together(), std::sqrt((1.0 + 27.0) / (4.0 + 48.0)));
  EXPECT_DOUBLE_EQ(errors.false_share(), 0.1);
  EXPECT_DOUBLE_EQ(errors.missed_share(), 0.2);
}

json crowd_of(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"study", "crowd", "--json", "-", "--quiet"});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return json::parse(result.out);
}

TEST(StudyCrowd, TellsContactsFromResponse) {
  // 30 meshes that have begun to land on each other.
  const std::vector<std::string> arguments = {"--bodies", "30", "--frames", "48", "--seeds", "1", "--every", "12"};
  const json study = crowd_of(arguments);
  EXPECT_EQ(study["schema"], "poise.crowd/1");
  const json& rows = study["rows"];
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_EQ(rows[0]["level"], "0");
  EXPECT_EQ(rows[4]["level"], "polygons");
  for (const json& row : rows) EXPECT_GT(row["frames"].get<int>(), 0);
  // What the polygons find is what the reference is made of.
  EXPECT_EQ(rows[4]["contacts_e_rel"].get<double>(), 0);
  EXPECT_EQ(rows[4]["response_e_rel"], rows[4]["e_rel"]);
  EXPECT_NE(rows[3]["response_e_rel"], rows[3]["e_rel"]);
  EXPECT_GT(rows[0]["contacts_e_rel"].get<double>(), rows[3]["contacts_e_rel"].get<double>());
  EXPECT_GT(rows[0]["e_rel"].get<double>(), rows[4]["e_rel"].get<double>());
  const json& noise = study["noise"];
  ASSERT_EQ(noise.size(), 9U);
  // Larger errors of normals, and of points, do more. In the median: one collision can make most of the error of all.
  EXPECT_GT(noise[5]["e_rel_p50"].get<double>(), noise[3]["e_rel_p50"].get<double>());
  EXPECT_GT(noise[8]["e_rel_p50"].get<double>(), noise[6]["e_rel_p50"].get<double>());
  EXPECT_GT(noise[6]["e_rel"].get<double>(), 0);
  // The same figures on one thread.
  std::vector<std::string> serial = arguments;
  serial.insert(serial.end(), {"--threads", "1"});
  const json alone = crowd_of(serial);
  EXPECT_EQ(alone["rows"], rows);
  EXPECT_EQ(alone["noise"], noise);
}

TEST(StudyCrowd, RefusesWhatContradicts) {
  EXPECT_EQ(poise_command({"study", "crowd", "--seeds", "0"}).exit_code, 2);
  const CommandResult result = poise_command({"study", "crowd", "--json", "same", "--markdown", "same"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.error.find("same"), std::string::npos) << result.error;
}

}  // namespace
}  // namespace poise::testing
