#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "axode/model/description.hpp"

/// Files of meshes: a description names them, and they are found and read here.
namespace axode {

/// The file of a mesh, or a sentence that says why it was not found.
struct FoundMesh {
  std::filesystem::path file;
  std::string error;  ///< empty if the file exists
};

/// Finds the file of a mesh that a description names. `package://name/path` is searched in ROS_PACKAGE_PATH,
/// in share of AMENT_PREFIX_PATH and in the folders that hold the file of the description, and
/// `model://name/path` in GZ_SIM_RESOURCE_PATH, in GAZEBO_MODEL_PATH and in the same folders. `file://` and
/// absolute paths are used as they are. Any other path is relative to the folder of the description's file
/// or, if the description comes from no file, to the working directory.
FoundMesh find_mesh(const std::string& name, const Source& referenced_from);

inline constexpr std::size_t largest_mesh = std::size_t{64} << 20;  ///< largest size of a file, bytes

/// The contents of the file of a mesh, or a sentence that says what is wrong with it. A reader can rely on
/// these checks: the vertices are finite, the file has as many of them as it declares, and it refers to no
/// other file. The formats are STL, OBJ, COLLADA (.dae) and glTF (.glb, .gltf).
struct MeshFile {
  std::string format;  ///< stl, obj, dae, glb or gltf
  std::string bytes;   ///< contents of the file; empty if error is not
  std::string error;   ///< empty if all checks pass
};
/// Reads and checks the file of a mesh, which may have at most `largest_mesh` bytes. The format follows from
/// the ending of its name, in upper or lower case.
MeshFile read_mesh(const std::filesystem::path& file);

}  // namespace axode
