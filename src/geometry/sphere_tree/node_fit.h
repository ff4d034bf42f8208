// SPDX-License-Identifier: MIT
#pragma once

#include "geometry/bvh/triangle_bvh.h"
#include "parallel/executor.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {

/// Fills tree.fit: for each node the sphere that represents it in contacts with bodies outside (docs/method.md, "The
/// contact of a pair"). The samples are points outside whose nearest point of the object is inside the node's sphere,
/// up to twice the mean radius of the node's level. So an edge or a corner is weighted by the volume from which it can
/// be touched. With p the nearest point of a sample, n the normal there and rho the mean radius of the level, the
/// centre c' and radius r' minimise the squares of |p + rho n - c'| - (rho + r'), with a small weight toward the node's
/// own sphere less its mean protrusion. Protrusions must have been measured. A node without surface gets a large
/// negative radius, so that it is used only if no other node has a surface. The result does not depend on the executor.
void fit_nodes(SphereTree& tree, const TriangleMesh& mesh, const TriangleBvh& bvh, parallel::Executor& executor);

/// The same for a tree whose leaves are the object and whose inner spheres contain the leaves below them: the fit of a
/// leaf is the leaf itself.
void fit_nodes_to_leaves(SphereTree& tree);

/// Sets each node's own sphere as its fit, for trees of which only the spheres are known.
void fit_nodes_to_themselves(SphereTree& tree);

}  // namespace poise::geometry
