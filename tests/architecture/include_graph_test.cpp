// SPDX-License-Identifier: MIT
#include "architecture/include_graph.h"

#include <gtest/gtest.h>

#include <string>

namespace poise::tests {
namespace {

IncludeGraph two_rooms() {
  IncludeGraph graph;
  graph.rooms["geometry"] = {2, {"bvh"}, 3, 400};
  graph.rooms["solver"] = {5, {}, 1, 1200};
  graph.includes[{"solver", "geometry"}] = 4;
  return graph;
}

TEST(IncludeGraph, IsInOrderWhereRoomsIncludeEarlierOnes) {
  IncludeGraph graph = two_rooms();
  EXPECT_EQ(against_order(graph), std::set<std::string>{});
  graph.includes[{"geometry", "solver"}] = 1;
  EXPECT_EQ(against_order(graph), std::set<std::string>{"geometry -> solver"});
}

TEST(IncludeGraph, IsDrawnWithRedArrowsAgainstTheOrder) {
  IncludeGraph graph = two_rooms();
  const std::string sound = to_svg(graph);
  EXPECT_NE(sound.find(">geometry<"), std::string::npos);
  EXPECT_NE(sound.find("1 files, 1,200 lines"), std::string::npos);
  EXPECT_NE(sound.find("solver includes geometry, 4 lines"), std::string::npos);
  EXPECT_EQ(sound.find("#d00000"), std::string::npos);
  graph.includes[{"geometry", "solver"}] = 1;
  EXPECT_NE(to_svg(graph).find("#d00000"), std::string::npos);
}

TEST(IncludeGraph, OfTheRepositoryFindsTheRoomsAndTheirIncludes) {
  const IncludeGraph graph = read_include_graph(POISE_SOURCE_DIR);
  ASSERT_TRUE(graph.rooms.contains("collision"));
  EXPECT_TRUE(graph.rooms.at("collision").folders.contains("manifold"));
  EXPECT_GT(graph.includes.at({"frame", "collision"}), 0U);
  EXPECT_FALSE(graph.includes.contains({"scheduler", "geometry"}));
  for (const auto& [name, room] : graph.rooms)
    EXPECT_NE(to_svg(graph).find(name == "interface" || name == "values" ? "include/poise" : ">" + name + "<"),
              std::string::npos)
        << name << " is in no library of the picture";
}

}  // namespace
}  // namespace poise::tests
