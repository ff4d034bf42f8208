// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "poise/assets/tree_formats.h"
#include "poise/sphere_tree.h"

// One pair of functions for each format that holds levels of spheres: writing spheres as text, and reading them.
// Readers refuse with the position in the file, without its name, and check each sphere with take_sphere.
namespace poise::geometry {

/// Smallest, mean and largest protrusion of a level's spheres, each by its own largest, in metres.
struct LevelErrors {
  double best_m = 0, mean_m = 0, worst_m = 0;
};
LevelErrors level_errors(const SphereTree& tree, std::span<const NodeIndex> nodes);

/// Whether the tree's protrusions were measured. Files do not hold them, so they are 0 after reading. If they were
/// measured, some node of a tree of several nodes protrudes; a single sphere may be the object itself.
bool protrusions_known(const SphereTree& tree);

std::string urdf_text(std::span<const Sphere> spheres, const std::string& name);
Result<std::vector<Sphere>> urdf_spheres(const std::string& text, const SphereChoice& choice);

std::string curobo_text(std::span<const Sphere> spheres, const std::string& name);
Result<std::vector<Sphere>> curobo_spheres(const std::string& text, const SphereChoice& choice);

std::string foam_text(const SphereTree& tree, Level level);
Result<std::vector<Sphere>> foam_spheres(const std::string& text, const SphereChoice& choice);

/// Reads a number of a file. Blanks around it are allowed, other characters are not. An empty string and NaN are not
/// numbers.
bool read_number(std::string_view text, double& value);

/// Appends a sphere that was read at `place`. Refused: a centre or radius out of range, and more than kMaxUnionSpheres
/// spheres.
Status take_sphere(const Sphere& sphere, const std::string& place, std::vector<Sphere>& spheres);

/// The chosen one of `links`, which have spheres. Refused: no link, an unknown choice, or several links without a
/// choice (the message names them).
Result<std::string> chosen_link(const std::vector<std::string>& links, const std::string& choice);

/// Text of a file for a message: at most `longest` characters, everything but printable ASCII replaced.
std::string shown_text(std::string_view text, std::size_t longest = 40);

}  // namespace poise::geometry
