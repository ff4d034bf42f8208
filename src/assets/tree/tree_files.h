// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "poise/assets/tree_formats.h"
#include "poise/sphere_tree.h"

// One pair of functions for each format that holds levels of spheres: text of spheres, and spheres of a text. The
// second ones are refused with the place in the file, without its name, and check what they take with take_sphere.
namespace poise::geometry {

/// Of the spheres of a level, each by its largest protrusion, in metres.
struct LevelErrors {
  double best_m = 0, mean_m = 0, worst_m = 0;
};
LevelErrors level_errors(const SphereTree& tree, std::span<const NodeIndex> nodes);

/// Whether the tree's protrusions were measured. Files do not have them, so that they are 0 after reading; measured,
/// some node of a tree of several nodes stands out of its object, while one sphere alone may well be its object.
bool protrusions_known(const SphereTree& tree);

std::string urdf_text(std::span<const Sphere> spheres, const std::string& name);
Result<std::vector<Sphere>> urdf_spheres(const std::string& text, const SphereChoice& choice);

std::string curobo_text(std::span<const Sphere> spheres, const std::string& name);
Result<std::vector<Sphere>> curobo_spheres(const std::string& text, const SphereChoice& choice);

std::string foam_text(const SphereTree& tree, Level level);
Result<std::vector<Sphere>> foam_spheres(const std::string& text, const SphereChoice& choice);

/// A number as files have it: blanks around it are fine, anything else beside it is not. Empty string and NaN are no
/// numbers.
bool read_number(std::string_view text, double& value);

/// Appends a sphere that was read at `place`. Refused: a centre or radius out of range, one sphere too many.
Status take_sphere(const Sphere& sphere, const std::string& place, std::vector<Sphere>& spheres);

/// The one of `links` that has spheres and was chosen. Refused: none, an unknown one, or several without a choice, by
/// name.
Result<std::string> chosen_link(const std::vector<std::string>& links, const std::string& choice);

/// Text of a file for a message: at most `longest` characters, everything but printable ASCII replaced.
std::string shown_text(std::string_view text, std::size_t longest = 40);

}  // namespace poise::geometry
