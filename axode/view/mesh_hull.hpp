#pragma once
#include "axode/contact/contact_shapes.hpp"

namespace axode {

/// The convex hull of the vertices of a mesh, for contacts: `ContactShapes(model, hull_of_mesh)`. Reads the
/// file that find_mesh() finds, which is an STL or OBJ, and computes the hull by Qhull. Faces whose normals
/// differ by less than 1e-4 rad become one face. Throws std::invalid_argument with a sentence if the file is
/// not found, is of another format, or has its vertices in one plane. Takes some milliseconds for 20,000
/// vertices.
MeshHull hull_of_mesh(const ShapeDescription& shape, const Source& referenced_from);

}  // namespace axode
