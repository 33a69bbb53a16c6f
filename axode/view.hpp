#pragma once
#include "axode/view/mesh_file.hpp"
#include "axode/view/mesh_hull.hpp"
#include "axode/view/scene.hpp"

/// Web pages that show mechanisms and motions, mesh files, and convex hulls of meshes for contacts.
