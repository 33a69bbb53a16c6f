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

/// A report on a scene: the meshes in it, and warnings about things that it does not show.
struct SceneContents {
  struct Mesh {
    std::string file;      ///< path at which it was found
    std::uintmax_t bytes;  ///< size of the file
  };
  std::vector<Mesh> meshes;
  std::vector<std::string> warnings;  ///< warnings of the model, and of meshes that are missing or unreadable
};

/// Options of write_scene() and write_page().
struct SceneOptions {
  ShownMotion motion = {};  ///< motion to show; if it has no times there is none
  std::string live = {};    ///< address of a stream of events with states for the page; may be empty
};

/// Largest number of bytes of all mesh files of a scene together. Meshes beyond it are not shown.
inline constexpr std::size_t largest_meshes = std::size_t{256} << 20;
/// Largest number of numbers of a motion in a scene. Of a longer motion only every second, third, ... state
/// is shown.
inline constexpr std::size_t longest_motion = 1'000'000;

/// Configuration that a page shows first if no other is given: that of initial_state(), or, if the model has
/// loops or motions and assemble() can close and follow them from there, the closed one. The search ends if
/// monitor() returns false.
std::vector<double> first_configuration(const Model& model, const std::function<bool()>& monitor = {});

/// Writes the scene that a page shows as JSON: bodies with their joints and inertias, frames, shapes with the
/// contents of their mesh files, loops, the configuration q and a motion. The text can be embedded in an
/// element of HTML, whatever names are in the model. A body without a visible shape gets placeholder shapes.
/// Throws std::invalid_argument if q or the motion does not fit the model.
SceneContents write_scene(const Model& model, std::span<const double> q, std::ostream& out,
                          const SceneOptions& options = {});

/// Writes the page of the viewer with a scene in it: one file of HTML that needs no other file and no
/// network. `empty_page` is the page that the build of the viewer makes. Throws std::invalid_argument if it
/// is another text, and as write_scene() does.
SceneContents write_page(std::string_view empty_page, const Model& model, std::span<const double> q,
                         std::ostream& out, const SceneOptions& options = {});

}  // namespace axode
