#pragma once
#include "axode/view/mesh_file.hpp"
#include "axode/view/scene.hpp"

/// Mechanisms and their motions as a page that a browser shows.
