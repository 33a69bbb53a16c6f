#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "axode/model/description.hpp"

/// Functions that find and read the files of meshes, which a description gives by their names.
namespace axode {

/// The file of a mesh or, if it was not found, a sentence with the reason.
struct FoundMesh {
  std::filesystem::path file;
  std::string error;  ///< empty if the file exists
};

/// Finds the file of a mesh by the name that a description has for it. `package://name/path` is searched in
/// the folders of ROS_PACKAGE_PATH, in the subfolder share of those of AMENT_PREFIX_PATH, and in the folder
/// of the description's file and all folders around it. `model://name/path` is searched in the folders of
/// GZ_SIM_RESOURCE_PATH, in those of GAZEBO_MODEL_PATH, and in the folder of the description's file and all
/// folders around it. `file://` and absolute paths are used as they are. Any other path is relative to the
/// folder of the description's file or, if the description comes from no file, to the working directory.
FoundMesh find_mesh(const std::string& name, const Source& referenced_from);

inline constexpr std::size_t largest_mesh = std::size_t{64} << 20;  ///< largest size of a mesh file, bytes

/// The contents of a mesh file or, if the file has a fault, a sentence about the fault. If `error` is empty,
/// the vertices are finite, the file has as many of them as it declares, and it needs no other file. The
/// formats are STL, OBJ, COLLADA (.dae) and glTF (.glb, .gltf).
struct MeshFile {
  std::string format;  ///< stl, obj, dae, glb or gltf
  std::string bytes;   ///< contents of the file; empty if there is an error
  std::string error;   ///< empty if all checks pass
};
/// Reads and checks the file of a mesh, which may have at most `largest_mesh` bytes. The format follows from
/// the ending of its name, in upper or lower case.
MeshFile read_mesh(const std::filesystem::path& file);

}  // namespace axode
