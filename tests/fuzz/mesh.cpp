#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "axode/view/mesh_formats.hpp"

/// For every sequence of bytes, the check of a mesh returns one short sentence about what is wrong, or
/// nothing.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace axode::view;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const auto check : {fault_of_stl, fault_of_obj, fault_of_dae, fault_of_glb, fault_of_gltf}) {
    const std::string sentence = check(bytes);
    if (sentence.size() > 200 || sentence.find('\n') != std::string::npos) std::abort();
  }
  return 0;
}
