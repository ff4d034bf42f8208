// SPDX-License-Identifier: MIT
// draw_rooms CHECKOUT FILE.svg: draws the include graph of the rooms; exits with 1 if an include breaks their order.
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>

#include "architecture/include_graph.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: draw_rooms CHECKOUT FILE.svg\n", stderr);
    return 2;
  }
  try {
    const poise::tests::IncludeGraph graph = poise::tests::read_include_graph(argv[1]);
    for (const std::string& arrow : poise::tests::against_order(graph))
      std::fprintf(stderr, "draw_rooms: %s is against the order of the rooms\n", arrow.c_str());
    std::ofstream file(argv[2], std::ios::binary);
    file << poise::tests::to_svg(graph);
    file.close();
    if (file) return poise::tests::against_order(graph).empty() ? 0 : 1;
    std::fprintf(stderr, "draw_rooms: %s cannot be written\n", argv[2]);
    return 4;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "draw_rooms: %s\n", error.what());
    return 3;
  }
}
