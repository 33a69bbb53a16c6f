#pragma once
#include "axode/view/mesh_file.hpp"
#include "axode/view/mesh_hull.hpp"
#include "axode/view/scene.hpp"

/// Pages for a browser that show mechanisms and their motions; reading of mesh files, and convex hulls of
/// meshes for contacts.
