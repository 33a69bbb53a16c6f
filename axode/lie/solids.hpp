#pragma once
#include <array>
#include <span>

#include "axode/lie/inertia.hpp"

/// Inertias of homogeneous solids, each in its own frame, for a mass in kg and lengths in m. transform(S, M)
/// expresses an inertia M in another frame, relative to which the frame of the solid has the pose S. All
/// functions throw std::invalid_argument if a mass or a length is not positive and finite.
namespace axode {

/// Inertia of a box about its centre; `size` are the lengths of the edges along x, y and z.
Inertia<> box_inertia(double mass, const Vec3<>& size);
/// Inertia of a ball about its centre.
Inertia<> sphere_inertia(double mass, double radius);
/// Inertia of a cylinder about its centre; the axis is along z.
Inertia<> cylinder_inertia(double mass, double radius, double length);
/// Inertia of a capsule about its centre: a cylinder of the given length along z with half balls at its ends.
Inertia<> capsule_inertia(double mass, double radius, double length);

/// Volume in m³ that a closed mesh of triangles encloses. A face is three indices of vertices,
/// counterclockwise as seen from outside. Throws std::invalid_argument if a vertex is not finite, if a face
/// has an index without a vertex, if the mesh is not closed (every edge must be shared by two faces that run
/// through it in opposite directions), or if the volume is not positive, for example because faces are
/// oriented inwards.
double mesh_volume(std::span<const Vec3<>> vertices, std::span<const std::array<int, 3>> faces);
/// Inertia of the homogeneous solid that a closed mesh of triangles encloses, in the frame of the vertices
/// and about the origin of this frame, which need not be inside. A face is three indices of vertices,
/// counterclockwise as seen from outside. Throws std::invalid_argument if the mass is not positive and
/// finite, and for every mesh that mesh_volume() does not accept.
Inertia<> mesh_inertia(double mass, std::span<const Vec3<>> vertices,
                       std::span<const std::array<int, 3>> faces);

}  // namespace axode
