#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "axode/lie/vec3.hpp"

/// Checks of the bytes of a mesh. Each function returns a sentence about the file that says what is wrong, or
/// an empty text if the checks pass.
namespace axode::view {

std::string fault_of_stl(std::string_view bytes);
std::string fault_of_obj(std::string_view bytes);
std::string fault_of_dae(std::string_view bytes);
std::string fault_of_glb(std::string_view bytes);
std::string fault_of_gltf(std::string_view bytes);

/// The corners of all triangles of an STL, and the vertices of an OBJ, in the units of the file. The bytes
/// must have passed the checks above.
std::vector<Vec3<>> vertices_of_stl(std::string_view bytes);
std::vector<Vec3<>> vertices_of_obj(std::string_view bytes);

}  // namespace axode::view
