#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "axode/lie/vec3.hpp"

/// Checks of mesh files. Each fault_of function returns a sentence about the first fault, or an empty text.
namespace axode::view {

std::string fault_of_stl(std::string_view bytes);
std::string fault_of_obj(std::string_view bytes);
std::string fault_of_dae(std::string_view bytes);
std::string fault_of_glb(std::string_view bytes);
std::string fault_of_gltf(std::string_view bytes);

/// The vertices in a file without a fault, in its units; of an STL the corners of all triangles.
std::vector<Vec3<>> vertices_of_stl(std::string_view bytes);
std::vector<Vec3<>> vertices_of_obj(std::string_view bytes);

}  // namespace axode::view
