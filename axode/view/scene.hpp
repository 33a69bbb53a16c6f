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
/// Largest count of numbers that the page may have for a motion. Of a longer motion only every second, third,
/// ... state is shown.
inline constexpr std::size_t longest_motion = 1'000'000;

/// The configuration that a page shows first if the caller gives no other one. It is that of initial_state()
/// or, if the model has loops or prescribed motions, the one that satisfies them and that assemble() finds
/// from there. If assemble() finds none, it is that of initial_state(). The caller can end the search:
/// monitor() is called now and then, and if it returns false, the search ends.
std::vector<double> first_configuration(const Model& model, const std::function<bool()>& monitor = {});

/// Writes the scene that a page shows as JSON: bodies with their joints and inertias, frames, shapes with the
/// contents of their mesh files, loops, the configuration q and a motion. The text can be embedded in an
/// element of HTML, whatever names the model has. Bodies without a visible shape get placeholder shapes.
/// Throws std::invalid_argument if q or the motion does not fit the model, or if their numbers are not
/// finite.
SceneContents write_scene(const Model& model, std::span<const double> q, std::ostream& out,
                          const SceneOptions& options = {});

/// Writes the page of the viewer with a scene in it: one HTML file that needs no other file and no network.
/// `empty_page` is the text of the page that the build of the viewer makes. Throws std::invalid_argument if
/// it is another text, or if write_scene() throws.
SceneContents write_page(std::string_view empty_page, const Model& model, std::span<const double> q,
                         std::ostream& out, const SceneOptions& options = {});

}  // namespace axode
