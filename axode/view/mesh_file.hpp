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

/// Finds the file of a mesh by its name in a description. The package of a name `package://package/path` is
/// searched in the folders of ROS_PACKAGE_PATH and in the subfolder `share` of the folders of
/// AMENT_PREFIX_PATH; the model of a name `model://model/path` in the folders of GZ_SIM_RESOURCE_PATH and
/// GAZEBO_MODEL_PATH. Packages and models are also searched in the folder of the description's file and in
/// all its parents. `file://` and absolute paths are used as they are; other paths are relative to the folder
/// of the description's file or, if the description has no file, to the working directory.
FoundMesh find_mesh(const std::string& name, const Source& referenced_from);

inline constexpr std::size_t largest_mesh = std::size_t{64} << 20;  ///< largest size of a mesh file, bytes

/// The contents of a mesh file or, if the file has a fault, a sentence about it. If there is no fault, all
/// vertices are finite, there are as many as the file declares, and no other file is needed. The formats are
/// STL, OBJ, COLLADA (.dae) and glTF (.glb, .gltf).
struct MeshFile {
  std::string format;  ///< stl, obj, dae, glb or gltf
  std::string bytes;   ///< contents of the file; empty if there is an error
  std::string error;   ///< empty if all checks pass
};
/// Reads and checks a mesh file of at most `largest_mesh` bytes, whose name's ending tells the format.
MeshFile read_mesh(const std::filesystem::path& file);

}  // namespace axode
