#pragma once
#include <string>
#include <string_view>

/// What is wrong with the bytes of a mesh, in a sentence without its subject; empty where all is well.
namespace axode::view {

std::string fault_of_stl(std::string_view bytes);
std::string fault_of_obj(std::string_view bytes);
std::string fault_of_dae(std::string_view bytes);
std::string fault_of_glb(std::string_view bytes);
std::string fault_of_gltf(std::string_view bytes);

}  // namespace axode::view
