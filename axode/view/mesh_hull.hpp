#pragma once
#include "axode/contact/contact_shapes.hpp"

namespace axode {

/// The convex hull of the vertices of a mesh. ContactShapes calls the function for collision shapes that are
/// meshes: `ContactShapes(model, hull_of_mesh)`. It reads the STL or OBJ file that find_mesh() finds, and
/// computes the hull by Qhull. Faces whose normals differ by less than 1e-4 rad become one face. It throws
/// std::invalid_argument, with a sentence as its message, if the file is not found, has a fault or another
/// format, or if all vertices are in one plane. It takes some milliseconds for 20,000 vertices.
MeshHull hull_of_mesh(const ShapeDescription& shape, const Source& referenced_from);

}  // namespace axode
