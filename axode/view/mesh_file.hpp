#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "axode/model/description.hpp"

/// Files of meshes, which a description names and nobody has opened yet.
namespace axode {

/// A file, or in a sentence why there is none.
struct FoundMesh {
  std::filesystem::path file;
  std::string why_not;  ///< empty: it is there
};

/// Where a mesh is that a description names: `package://name/path` in ROS_PACKAGE_PATH, in share of AMENT_PREFIX_PATH and
/// in the folders around the file that names it, `file://` and an absolute path as they are, and any other path beside that
/// file, or where the program runs for a description that no file told.
FoundMesh find_mesh(const std::string& name, const Source& told_in);

inline constexpr std::size_t largest_mesh = std::size_t{64} << 20;  ///< bytes

/// What a file of a mesh holds, checked as far as a reader must rely on it: finite vertices, as many as it says, and
/// nothing that lies in other files; or in a sentence what is wrong. STL, OBJ, COLLADA (.dae) and glTF (.glb, .gltf).
struct MeshFile {
  std::string format;  ///< stl, obj, dae, glb or gltf
  std::string bytes;
  std::string why_not;  ///< empty: all is well
};
MeshFile read_mesh(const std::filesystem::path& file);

}  // namespace axode
