// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "poise/mesh.h"
#include "poise/result.h"
#include "poise/sphere_tree.h"
#include "poise/types.h"

namespace poise {

enum class ShapeKind : std::uint8_t {
  Tree,   ///< a sphere tree; a ball is a tree of one node
  Plane,  ///< a half-space, static only
};

/// The triangles of a shape made from a mesh, beside the leaves of its tree; of private layout
/// (src/geometry/shape/shape_surface.h).
struct ShapeSurface;

/// What bodies share: a sphere tree and mass properties at density 1. Immutable once made, so any number of
/// bodies, Worlds and threads may hold it.
struct Shape {
  ShapeKind kind = ShapeKind::Tree;
  SphereTree tree;               ///< in the body frame: origin at the centre of mass, axes of the mesh
  double bounding_radius_m = 0;  ///< about the centre of mass, holds the whole root sphere
  Vec3 origin_offset_m =
      Vec3::Zero();                  ///< from the origin of the mesh (or of the list of spheres) to the centre of mass
  double volume_m3 = 0;              ///< mass at density 1
  Vec3 principal_m5 = Vec3::Zero();  ///< principal moments of inertia at density 1
  Quat principal_axes = Quat::Identity();  ///< turns the principal frame into the body frame
  Vec3 plane_normal = Vec3::UnitZ();       ///< Plane: unit normal, away from the solid side, in the body frame
  double plane_offset_m = 0;               ///< Plane: the surface is normal . x = offset
  std::shared_ptr<const ShapeSurface>
      surface;       ///< the true surface; null where the leaves are it (balls, unions of them), and for planes
  std::string note;  ///< what is not certain about inside and mass, one line; empty where nothing is
};

using ShapePtr = std::shared_ptr<const Shape>;

// All of these: any thread; refused with the name of the argument, its value and the rule. Where the inertia is
// diagonal in the axes of the mesh (to 1e-9 of its trace), principal_axes is exactly the identity and the principal
// moments stand in the order x, y, z; otherwise they ascend.

/// A ball about its centre; radius from 1e-9 to 1e9 m.
Result<ShapePtr> make_sphere_shape(double radius_m);

/// The half-space n . x <= offset_m with n = normal / |normal|; normal finite and not 0, offset along n within 1e9 m.
Result<ShapePtr> make_plane_shape(const Vec3& normal, double offset_m);

/// A rigid union of spheres, each counting whole for mass and inertia, also where they overlap.
Result<ShapePtr> make_spheres_shape(std::span<const Sphere> spheres);

/// A shape from a tree whose leaves are the true surface, each counting whole.
Result<ShapePtr> make_tree_shape(const SphereTree& tree);

/// A shape from a mesh, with a tree by build_sphere_tree. A closed mesh has its mass in closed form. An open one is
/// solid where its winding number is above one half, its mass is sampled (winding_mass_properties), and `note` says so.
/// With shell_thickness_m > 0 (1e-9 to 1e9) any mesh is its surface alone (Solidity::Shell whatever the options say),
/// with the mass of plates so thick; the thickness counts for the mass, not for the tree. Any thread. Refused as
/// build_sphere_tree does, and: a mesh that encloses nothing, or options that ask for a shell, without a thickness.
Result<ShapePtr> make_mesh_shape(const TriangleMesh& mesh, const TreeBuildOptions& options,
                                 double shell_thickness_m = 0);

/// The same with a tree that is there already, in the frame of the mesh, such as one from a file or a cache; whether it
/// covers the mesh is the caller's affair. Refused: as above, and an empty tree.
Result<ShapePtr> make_mesh_shape_with_tree(const TriangleMesh& mesh, const SphereTree& tree,
                                           double shell_thickness_m = 0);

}  // namespace poise
