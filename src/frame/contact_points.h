// SPDX-License-Identifier: MIT
#pragma once

#include "frame/manifolds.h"
#include "poise/world.h"

/// The points of listed contacts (Contact::points). They are made when somebody asks for contacts, from the contact
/// cache as the last step left it. Any thread.
namespace poise::simulation {

/// A pair of the last step and where its points are.
struct ListedPair {
  const PredictedMotion& motion;
  const PointCache& points;
  const ActivePair& pair;
  const PairPoints& made;
  double dt_s = 0;  ///< of the step
};

/// Fills the points of a contact whose impulse is known. `sign` is 1 where `pair` has the order of the contact, else
/// -1.
///
/// The cache holds the mean force of each point in the last substep, f_i; the contact knows the sum P over the step.
/// Point i gets s f_i with s = P . F / F . F, F the sum of all f_i, but from 0 to the length of the step, and of what
/// is left over its share by normal load, so that all add up to P. Where no point had an impulse, as after an impact,
/// each gets the same.
void list_points(const ListedPair& listed, double sign, Contact& contact);

/// Puts the points of `from` to those of `into`, the same pair. What has no room gives its impulse to the nearest one.
void merge_points(const Contact& from, Contact& into);

}  // namespace poise::simulation
