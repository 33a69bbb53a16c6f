#pragma once
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/view/shown_motion.hpp"

namespace axode {

/// A report on a scene: its meshes, and warnings about things that it does not show.
struct SceneContents {
  struct Mesh {
    std::string file;      ///< path of the mesh file
    std::uintmax_t bytes;  ///< size of the file
  };
  std::vector<Mesh> meshes;
  std::vector<std::string> warnings;  ///< warnings of the model, and about meshes that cannot be shown
};

/// Options of write_scene() and write_page().
struct SceneOptions {
  ShownMotion motion = {};  ///< motion to show; none is shown if it has no times
  std::string live = {};    ///< address of a stream from which the page gets states; may be empty
};

/// Largest total size of the mesh files of a scene, bytes. Meshes that would exceed it are not shown.
inline constexpr std::size_t largest_meshes = std::size_t{256} << 20;
/// The largest count of numbers for a motion on a page; of a longer motion some states are left out.
inline constexpr std::size_t longest_motion = 1'000'000;

/// The configuration that the viewer shows first. It is the initial configuration of the model, from which
/// the joints are moved until the loops are closed and the prescribed motions satisfied, if this succeeds.
/// The search ends early if monitor(), which is called now and then, returns false.
std::vector<double> first_configuration(const Model& model, const std::function<bool()>& monitor = {});

/// Writes the scene that the viewer shows as JSON: bodies with their joints and inertias, frames, shapes with
/// the contents of their mesh files, loops, the configuration q and a motion. Bodies without a visible shape
/// get placeholders. Throws std::invalid_argument if q or the motion does not fit the model, or if their
/// numbers are not finite.
SceneContents write_scene(const Model& model, std::span<const double> q, std::ostream& out,
                          const SceneOptions& options = {});

/// Writes one HTML file that contains the viewer and a scene, and needs no other file and no network.
/// `empty_page` is the viewer's page without a scene. Throws std::invalid_argument if `empty_page` is not
/// this page, or if the scene has a fault.
SceneContents write_page(std::string_view empty_page, const Model& model, std::span<const double> q,
                         std::ostream& out, const SceneOptions& options = {});

}  // namespace axode
