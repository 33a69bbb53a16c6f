#pragma once
#include <string>
#include <string_view>

/// Checks of the bytes of a mesh. Each function returns a sentence about the file that says what is wrong, or
/// an empty text if the checks pass.
namespace axode::view {

std::string fault_of_stl(std::string_view bytes);
std::string fault_of_obj(std::string_view bytes);
std::string fault_of_dae(std::string_view bytes);
std::string fault_of_glb(std::string_view bytes);
std::string fault_of_gltf(std::string_view bytes);

}  // namespace axode::view
