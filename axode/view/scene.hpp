#pragma once
#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/view/shown_motion.hpp"

namespace axode {

/// What went into a scene, and what did not.
struct SceneContents {
  struct Mesh {
    std::string file;  ///< where it was found
    std::uintmax_t bytes;
  };
  std::vector<Mesh> meshes;
  std::vector<std::string> warnings;  ///< those of the model, and of meshes that are missing or unreadable
};

struct SceneOptions {
  ShownMotion motion = {};  ///< none where it has no times
  std::string live =
      {};  ///< where the page is told states, the address of a stream of events; empty: nowhere
};

inline constexpr std::size_t largest_meshes = std::size_t{256} << 20;  ///< bytes of all meshes of a scene
/// Numbers of a motion in a scene; of a longer one every second, third, ... state is shown.
inline constexpr std::size_t longest_motion = 1'000'000;

/// Writes what a page shows as JSON: bodies with their joints and inertias, frames, shapes with the files of their meshes
/// in them, loops, a state and a motion. Whatever names there are, it can stand in an element of HTML. A body without a
/// shape that is seen has stand-ins. Throws std::invalid_argument for a q or a motion that does not fit the model.
SceneContents write_scene(const Model& model, std::span<const double> q, std::ostream& out,
                          const SceneOptions& options = {});

/// Writes the page of the viewer with a scene in it: one file of HTML that needs no other and no network. `empty_page` is
/// what the viewer's build gives. Throws std::invalid_argument where that is something else.
SceneContents write_page(std::string_view empty_page, const Model& model, std::span<const double> q,
                         std::ostream& out, const SceneOptions& options = {});

}  // namespace axode
