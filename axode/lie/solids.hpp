#pragma once
#include <array>
#include <span>

#include "axode/lie/inertia.hpp"

/// Inertias of homogeneous solids, each in its own frame, for a mass in kg and lengths in m;
/// transform(S, M) puts them where they belong. All throw std::invalid_argument for a mass or a length that is not
/// positive and finite.
namespace axode {

/// A box about its centre, with edges of the lengths of `size` along x, y and z.
Inertia<> box_inertia(double mass, const Vec3<>& size);
/// A ball about its centre.
Inertia<> sphere_inertia(double mass, double radius);
/// A cylinder about its centre, its axis along z.
Inertia<> cylinder_inertia(double mass, double radius, double length);
/// A cylinder along z of this length with a half ball on each end, about its centre.
Inertia<> capsule_inertia(double mass, double radius, double length);

/// What a closed mesh of triangles encloses, in m³. A face is three numbers of vertices, counterclockwise as seen from
/// outside. Throws std::invalid_argument for a vertex that there is not, or is not finite, for a mesh that is not closed
/// (every edge must be shared by two faces that run through it in opposite directions) and for a volume that is not
/// positive, as where the faces look inwards.
double mesh_volume(std::span<const Vec3<>> vertices, std::span<const std::array<int, 3>> faces);
/// The inertia of this solid in the frame of the vertices, about its origin, which need not be inside.
Inertia<> mesh_inertia(double mass, std::span<const Vec3<>> vertices,
                       std::span<const std::array<int, 3>> faces);

}  // namespace axode
