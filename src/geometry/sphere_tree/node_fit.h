// SPDX-License-Identifier: MIT
#pragma once

#include "geometry/bvh/triangle_bvh.h"
#include "parallel/executor.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {

/// Fills tree.fit: for each node the sphere that a body from outside meets in its stead (docs/method.md, "The contact
/// of a pair"). The part of the outside whose nearest point of the object is inside a node's sphere is sampled up to
/// twice the mean radius of the node's level, so that an edge or a corner counts by the room from which it can be met;
/// each sample's nearest point p with the normal n there asks for |p + rho n - c'| = rho + r' with rho the mean radius
/// of the level, in the sense of least squares, drawn gently toward the node's own sphere less its mean protrusion.
/// Protrusions must have been measured. A node without surface gets a radius so negative that it never answers while
/// another does. The result does not depend on the executor.
void fit_nodes(SphereTree& tree, const TriangleMesh& mesh, const TriangleBvh& bvh, parallel::Executor& executor);

/// The same for a tree whose leaves are the object and whose inner spheres hold the leaves below them: a leaf is its
/// own fit.
void fit_nodes_to_leaves(SphereTree& tree);

/// The sphere of each node as its own fit: for trees of which nothing is known but their spheres.
void fit_nodes_to_themselves(SphereTree& tree);

}  // namespace poise::geometry
