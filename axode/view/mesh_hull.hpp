#pragma once
#include "axode/contact/contact_shapes.hpp"

namespace axode {

/// The convex hull of the vertices of an STL or OBJ mesh, for contacts: `ContactShapes(model, hull_of_mesh)`.
/// Faces whose normals differ by less than 1e-4 rad become one. Throws std::invalid_argument if the file is
/// not found, has a fault or another format, or if all vertices are in one plane. It takes some milliseconds
/// for 20,000 vertices.
MeshHull hull_of_mesh(const ShapeDescription& shape, const Source& referenced_from);

}  // namespace axode
