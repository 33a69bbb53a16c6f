#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "axode/lie/vec3.hpp"

/// Checks of the contents of mesh files. Each fault_of function returns a sentence about the first fault in
/// the file, or an empty text if there is none.
namespace axode::view {

std::string fault_of_stl(std::string_view bytes);
std::string fault_of_obj(std::string_view bytes);
std::string fault_of_dae(std::string_view bytes);
std::string fault_of_glb(std::string_view bytes);
std::string fault_of_gltf(std::string_view bytes);

/// vertices_of_stl() returns the corners of all triangles, three for each, and vertices_of_obj() the
/// vertices, in the units of the file. fault_of_stl() or fault_of_obj() must have found no fault in the
/// bytes.
std::vector<Vec3<>> vertices_of_stl(std::string_view bytes);
std::vector<Vec3<>> vertices_of_obj(std::string_view bytes);

}  // namespace axode::view
