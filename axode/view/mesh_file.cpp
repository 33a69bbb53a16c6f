#include "axode/view/mesh_file.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

#include "axode/view/mesh_formats.hpp"

namespace axode {
namespace {

namespace fs = std::filesystem;

std::string in_quotes(const std::string& text) { return '"' + text + '"'; }
std::string in_quotes(const fs::path& path) { return in_quotes(path.string()); }

bool is_file(const fs::path& path) {
  std::error_code unknown;
  return fs::is_regular_file(path, unknown);
}

/// The folders in the value of an environment variable, where colons separate them.
std::vector<fs::path> folders_of(const char* variable) {
  std::vector<fs::path> folders;
  const char* value = std::getenv(variable);
  std::string_view rest = value == nullptr ? "" : value;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    if (end > 0) folders.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return folders;
}

/// A URI scheme for files in packages (package:// or model://), and where its packages are searched.
struct Library {
  std::string_view scheme;
  std::string_view what;                 ///< word for a package in messages
  std::string_view manifest, element;    ///< XML file in a package, and its root element, which holds <name>
  std::array<const char*, 2> variables;  ///< environment variables whose folders hold packages
  std::string_view below_second;         ///< subfolder of the second variable's folders with the packages
};
constexpr Library ros{
    "package://", "package", "package.xml", "package", {"ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"}, "share"};
constexpr Library gazebo{
    "model://", "model", "model.config", "model", {"GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH"}, ""};

/// Whether a folder is the package with a name, by its own name or by the name in its manifest.
bool is_package(const fs::path& folder, const std::string& name, const Library& library) {
  if (folder.filename() == name) return true;
  tinyxml2::XMLDocument manifest;
  const fs::path file = folder / library.manifest;
  if (!is_file(file) || manifest.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS) return false;
  const tinyxml2::XMLElement* package = manifest.FirstChildElement(std::string(library.element).c_str());
  const tinyxml2::XMLElement* name_element =
      package == nullptr ? nullptr : package->FirstChildElement("name");
  return name_element != nullptr && name_element->GetText() != nullptr && name_element->GetText() == name;
}

/// Existing folders that may be a package, the likeliest first; `folder` is that of the mechanism's file.
std::vector<fs::path> packages(const std::string& name, const fs::path& folder, const Library& library) {
  std::vector<fs::path> found;
  std::error_code unknown;
  const auto look_at = [&](const fs::path& package) {
    if (fs::is_directory(package, unknown)) found.push_back(package);
  };
  const auto look_in = [&](const fs::path& root) {
    if (is_package(root, name, library)) look_at(root);
    look_at(root / name);
  };
  for (const fs::path& root : folders_of(library.variables[0])) look_in(root);
  for (const fs::path& root : folders_of(library.variables[1])) look_at(root / library.below_second / name);
  for (fs::path around = fs::absolute(folder, unknown); !around.empty(); around = around.parent_path()) {
    look_in(around);
    if (around == around.root_path()) break;
  }
  return found;
}

/// Finds a file `package/path` in the packages of a URI scheme; `folder` is that of the mechanism's file.
FoundMesh in_package(std::string_view name_and_path, const fs::path& folder, const Library& library) {
  const std::size_t slash = name_and_path.find('/');
  const std::string name(name_and_path.substr(0, slash)), what(library.what);
  const fs::path path = slash == std::string_view::npos
                            ? fs::path()
                            : fs::path(name_and_path.substr(slash + 1)).lexically_normal();
  if (name.empty() || name == "." || name == ".." || path.empty() || path.is_absolute() ||
      *path.begin() == "..")
    return {{}, "it is not a path within a " + what};
  const std::vector<fs::path> roots = packages(name, folder, library);
  for (const fs::path& root : roots)
    if (is_file(root / path)) return {root / path, ""};
  if (!roots.empty())
    return {{},
            what + " " + in_quotes(name) + " is in " + in_quotes(roots.front()) + ", which has no file " +
                in_quotes(path)};
  return {{},
          "there is no " + what + " " + in_quotes(name) + " in " + library.variables[0] + ", in " +
              library.variables[1] + " and in " + in_quotes(folder) + " and the folders that hold it"};
}

/// A path in which escapes such as %20 are replaced by the bytes that they encode.
std::string decoded(std::string_view text) {
  std::string out;
  for (std::size_t k = 0; k < text.size(); ++k) {
    unsigned char byte = 0;
    const bool escaped = text[k] == '%' && k + 2 < text.size() &&
                         std::from_chars(&text[k + 1], &text[k + 1] + 2, byte, 16).ptr == &text[k + 1] + 2;
    out += escaped ? static_cast<char>(byte) : text[k];
    if (escaped) k += 2;
  }
  return out;
}

/// The text after its beginning `start`; no value if it begins differently.
std::optional<std::string_view> behind(std::string_view text, std::string_view start) {
  if (!text.starts_with(start)) return std::nullopt;
  return text.substr(start.size());
}

using Check = std::string (*)(std::string_view);
struct MeshFormat {
  std::string_view name;
  Check fault;
};
constexpr std::array<MeshFormat, 5> mesh_formats{{{"stl", view::fault_of_stl},
                                                  {"obj", view::fault_of_obj},
                                                  {"dae", view::fault_of_dae},
                                                  {"glb", view::fault_of_glb},
                                                  {"gltf", view::fault_of_gltf}}};

}  // namespace

FoundMesh find_mesh(const std::string& name, const Source& referenced_from) {
  fs::path folder = fs::path(referenced_from.file).parent_path() / "";
  if (folder.empty()) folder = ".";
  if (name.find('\0') != std::string::npos) return {{}, "there is a zero byte in its name"};
  for (const Library& library : {ros, gazebo})
    if (const auto rest = behind(name, library.scheme)) return in_package(*rest, folder, library);
  fs::path file = name;
  if (auto rest = behind(name, "file://")) {
    if (const auto here = behind(*rest, "localhost")) rest = here;
    if (!rest->starts_with('/')) return {{}, "it is on another machine"};
    file = decoded(*rest);
  } else if (const std::size_t colon = name.find("://"); colon != std::string::npos) {
    return {{}, in_quotes(name.substr(0, colon + 3)) + " is none of package://, model://, file://"};
  }
  file = (folder / file).lexically_normal();  // an absolute path does not change
  if (name.empty()) return {{}, "its file has no name"};
  if (!is_file(file)) return {{}, "there is no file " + in_quotes(file)};
  return {file, ""};
}

MeshFile read_mesh(const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; });
  const auto format = std::ranges::find_if(
      mesh_formats, [&](const MeshFormat& each) { return ending == '.' + std::string(each.name); });
  if (format == mesh_formats.end())
    return {"", "", "its ending " + in_quotes(ending) + " is none of .stl, .obj, .dae, .glb, .gltf"};
  MeshFile mesh{std::string(format->name), "", ""};
  std::error_code unknown;
  const std::uintmax_t size = fs::file_size(file, unknown);
  if (unknown) {
    mesh.error = "it cannot be read: " + unknown.message();
  } else if (size > largest_mesh) {
    mesh.error = "it has " + std::to_string(size >> 20) + " MiB; a mesh may have " +
                 std::to_string(largest_mesh >> 20);
  } else {
    std::ifstream stream(file, std::ios::binary);
    mesh.bytes.resize(size);
    stream.read(mesh.bytes.data(), static_cast<std::streamsize>(size));
    mesh.error = stream ? format->fault(mesh.bytes) : "it cannot be read";
  }
  if (!mesh.error.empty()) mesh.bytes.clear();
  return mesh;
}

}  // namespace axode
