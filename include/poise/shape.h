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

/// How the surface of a shape is modelled.
enum class ShapeKind : std::uint8_t {
  Tree,   ///< a sphere tree; a ball is a tree of one node
  Plane,  ///< a half-space, static only
};

/// The triangles of a shape that was made from a mesh, beside the leaves of its tree. Its layout is private
/// (src/geometry/shape/shape_surface.h).
struct ShapeSurface;

/// The part of a body that bodies share: a sphere tree and mass properties at density 1 kg/m^3. Immutable once made, so
/// any number of bodies, Worlds and threads may share it.
struct Shape {
  ShapeKind kind = ShapeKind::Tree;
  SphereTree tree;               ///< in the body frame: origin at the centre of mass, axes of the mesh
  double bounding_radius_m = 0;  ///< about the centre of mass; contains the whole root sphere
  /// From the origin of the mesh (or of the list of spheres) to the centre of mass, in the frame of the mesh.
  Vec3 origin_offset_m = Vec3::Zero();
  double volume_m3 = 0;                    ///< equals the mass in kg at density 1 kg/m^3
  Vec3 principal_m5 = Vec3::Zero();        ///< principal moments of inertia at density 1 kg/m^3
  Quat principal_axes = Quat::Identity();  ///< rotates the principal frame into the body frame
  Vec3 plane_normal = Vec3::UnitZ();       ///< Plane: unit normal, away from the solid side, in the body frame
  double plane_offset_m = 0;               ///< Plane: the surface is normal . x = offset
  /// The true surface. Null where the leaves are the true surface (balls, unions of them), and for planes.
  std::shared_ptr<const ShapeSurface> surface;
  std::string note;  ///< what is uncertain about inside and mass, one line; empty if nothing is
};

using ShapePtr = std::shared_ptr<const Shape>;

// All of these: any thread. Refused with the name of the argument, its value and the rule. If the inertia is diagonal
// in the axes of the mesh (to 1e-9 of its trace), principal_axes is exactly the identity and the principal moments are
// in the order x, y, z; otherwise they ascend.

/// A ball about its centre. Radius in [1e-9, 1e9] m.
Result<ShapePtr> make_sphere_shape(double radius_m);

/// The half-space n . x <= offset_m with n = normal / |normal|. `normal` must be finite and not 0, offset_m within 1e9
/// m.
Result<ShapePtr> make_plane_shape(const Vec3& normal, double offset_m);

/// A rigid union of spheres. Each sphere contributes its whole mass and inertia, also where spheres overlap. Refused as
/// tree_of_spheres.
Result<ShapePtr> make_spheres_shape(std::span<const Sphere> spheres, const UnionTreeOptions& options = {});

/// A shape from a tree whose leaves are the true surface. Each leaf contributes its whole mass and inertia. Refused: a
/// tree that is not arranged as SphereTree says, numbers in it that are not finite or beyond 4e9 m, leaves with a
/// radius below 1e-9 m.
Result<ShapePtr> make_tree_shape(const SphereTree& tree);

/// A shape from a mesh, with a tree by build_sphere_tree. The mass of a closed mesh is in closed form. An open mesh is
/// solid where its winding number is above one half; its mass is sampled (winding_mass_properties), and `note` says so.
/// With shell_thickness_m > 0 (in [1e-9, 1e9] m) any mesh is its surface alone (Solidity::Shell whatever the options
/// say), with the mass of plates of this thickness; the thickness affects the mass, not the tree. Any thread. Refused:
/// as build_sphere_tree; and without a thickness, a mesh that encloses nothing or options that ask for a shell.
Result<ShapePtr> make_mesh_shape(const TriangleMesh& mesh, const TreeBuildOptions& options,
                                 double shell_thickness_m = 0);

/// The same with an existing tree in the frame of the mesh, e.g. from a file or a cache. It is not checked whether the
/// tree covers the mesh. Refused: as above, and a tree that is not arranged as SphereTree says or has numbers out of
/// range.
Result<ShapePtr> make_mesh_shape_with_tree(const TriangleMesh& mesh, const SphereTree& tree,
                                           double shell_thickness_m = 0);

}  // namespace poise
