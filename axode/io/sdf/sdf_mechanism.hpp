#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "axode/io/sdf/sdf_frames.hpp"
#include "axode/io/xml_reader.hpp"

/// The conversion of the links and joints of an SDF file into the bodies and loops of a description.
namespace axode::io {

/// A type of joint in SDFormat, and the kinds of joint in a tree and of loop joint that it becomes.
struct SdfKind {
  std::string_view type;
  JointKind kind;
  LoopKind loop;
};
inline constexpr std::array<SdfKind, 9> sdf_kinds{{
    {"revolute", JointKind::revolute, LoopKind::revolute},
    {"continuous", JointKind::revolute, LoopKind::revolute},  // without limits
    {"prismatic", JointKind::prismatic, LoopKind::prismatic},
    {"screw", JointKind::helical, LoopKind::helical},
    {"universal", JointKind::universal, LoopKind::universal},
    {"revolute2", JointKind::universal, LoopKind::universal},
    {"ball", JointKind::spherical, LoopKind::spherical},
    {"fixed", JointKind::fixed, LoopKind::fixed},
    {"gearbox", JointKind::fixed, LoopKind::fixed},  // becomes a coupling
}};

/// Turns links, joints and frames of SDFormat into bodies, loops and couplings: it finds a spanning tree of
/// the links, and the other joints close loops.
class SdfMechanism : protected XmlReader {
 protected:
  using XmlReader::XmlReader;

  using Kind = SdfFrames::Kind;
  struct Link {
    int frame = 0;
    BodyDescription body;
    std::vector<std::string> shape_frames = {};  ///< frame to which each shape's pose is relative
    bool is_static = false;
  };
  struct Mimic {
    std::string leader, axis;
    double ratio = 1, offset = 0;
    int line = 0;
  };
  struct Axis {
    Vec3<> xyz{0, 0, 1};
    std::string expressed_in;
    Dof dof;
    std::optional<Mimic> mimic = {};
  };
  struct Connection {
    int frame = 0;
    std::string name, parent, child;
    const SdfKind* kind = nullptr;
    std::array<Axis, 2> axes = {};
    double pitch = 0, gear_ratio = 1;
    std::string gear_reference;
    bool is_static = false;
    int line = 0;
    int from = -1, to = -1;  ///< indices of the parent and child links; -1 for the world
    bool in_tree = false, reversed = false;
  };

  /// The name of a frame here, its path without the name of the only model at the top, if there is only one.
  std::string shown(const std::string& path) const {
    return models_at_top_ == 1 && path.starts_with(top_) ? path.substr(top_.size()) : path;
  }
  std::string element(std::string_view what, const std::string& path) const {
    return std::string(what) + " \"" + shown(path) + '"';
  }

  Link& link(int k) { return links_[static_cast<std::size_t>(k)]; }

  /// Converts the poses of shapes that are relative to other frames into poses in the frames of their links.
  void finish_shapes();
  /// Adds bodies (first the root links, to which no joint of the spanning tree leads, then in the order of
  /// their joints), loops, couplings and named frames to the description.
  void assemble();

  SdfFrames frames_;
  std::vector<Link> links_;
  std::vector<Connection> connections_;
  std::unordered_map<int, int> link_of_frame_;
  std::vector<int> named_frames_;
  std::string top_;  ///< name of the first model at the top of the file, followed by `::`
  std::size_t models_at_top_ = 0;

 private:
  std::optional<int> link_meant(const Connection& c, const std::string& name, const char* role);
  std::string named_here(const std::string& name, int line);
  bool connect(Connection& c);
  std::vector<std::size_t> grow_tree();
  void add_roots(const std::vector<std::size_t>& roots);
  void add(Link& link);
  Vec3<> axis_of(const Connection& c, std::size_t number);
  void add_body(const Connection& c);
  void add_loop(const Connection& c);
  static std::string name_about_axis(const Connection& c, bool second);
  std::string coordinate_of(const Connection& c, const Mimic& mimic);
  void add_couplings(const Connection& c);
  void add_gearbox(const Connection& c);
  void add_frame(int number);

  std::unordered_map<int, std::size_t> connection_of_frame_;
  std::map<std::pair<int, int>, std::size_t> hinges_;  ///< revolute joints of the tree, by their two links
};

}  // namespace axode::io
