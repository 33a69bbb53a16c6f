#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "axode/lie/se3.hpp"
#include "axode/model/force_law.hpp"

namespace axode {

/// The kinds of springs. The comment of each kind names the coordinate on which the force depends.
enum class SpringKind {
  line,     ///< the distance of two points
  tendon,   ///< the length of a path of points with straight segments
  torsion,  ///< the angle of two frames about an axis
  joints,   ///< Σ factor q of the coordinates of joints of one velocity
  bushing,  ///< the pose of one frame relative to another, with a stiffness for all six directions
};

/// The properties of a kind of springs. All but bushings have a ForceLaw of one length or angle.
struct SpringTraits {
  SpringKind kind;
  std::string_view name;
  std::string_view stiffness;            ///< unit of the stiffness for messages
  std::string_view damping;              ///< unit of the damping
  std::array<std::string_view, 5> keys;  ///< keys of the drawing format that place the spring

  constexpr bool has(std::string_view key) const {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  }
};
inline constexpr std::array<SpringTraits, 5> spring_kinds{{
    {SpringKind::line, "line", "N/m", "N s/m", {"between", "points", "in"}},
    {SpringKind::tendon, "tendon", "N/m", "N s/m", {"path", "in"}},
    {SpringKind::torsion, "torsion", "N m/rad", "N m s/rad", {"between", "axis", "frames", "in"}},
    {SpringKind::joints, "joints", "N m/rad or N/m", "N m s/rad or N s/m", {"terms"}},
    {SpringKind::bushing,
     "bushing",
     "N m/rad and N/m",
     "N m s/rad and N s/m",
     {"between", "pose", "frames", "in", "rest_pose"}},
}};
constexpr const SpringTraits& traits(SpringKind kind) {
  return *std::find_if(spring_kinds.begin(), spring_kinds.end(),
                       [&](const SpringTraits& t) { return t.kind == kind; });
}
constexpr std::string_view to_string(SpringKind kind) { return traits(kind).name; }

/// A 6×6 matrix, stored by rows; the three angular rows and columns are before the linear ones.
using SixBySix = std::array<std::array<double, 6>, 6>;

/// A spring and damper as the kernels read it, see spring_forces().
struct Spring {
  /// A path of straight segments through two or more points; the spring of kind `line` has two.
  struct Path {
    struct Point {
      int frame = 0;
      Vec3<> point{};  ///< point in that frame, m
    };
    std::vector<Point> points;
  };
  /// A frame on which an end of the spring is, and the pose of the end in this frame.
  struct End {
    int frame = 0;
    SE3<> pose;
  };
  /// The coordinate of a torsion spring is the angle about z between the frames of its two ends.
  struct Torsion {
    std::array<End, 2> ends;
  };
  /// The coordinate Σ factor q + offset of a spring on joints; for a coupled joint q is that of its leader.
  struct JointSum {
    struct Term {
      int coordinate = 0, velocity = 0;
      double factor = 0;
    };
    std::vector<Term> terms;
    double offset = 0;
  };
  struct Bushing {
    std::array<End, 2> ends;
    SE3<> rest;     ///< pose of the second frame in the first one without a wrench
    SixBySix K, C;  ///< stiffness and damping, symmetric
  };

  std::string name;
  std::variant<Path, Torsion, JointSum, Bushing> geometry;
  ForceLaw law = {};  ///< not used by bushings

  bool on_joints() const { return std::holds_alternative<JointSum>(geometry); }
};

/// The springs, dampers and elastic stops of a mechanism, and the lines of its drives.
struct Springs {
  std::vector<int> joints;       ///< joints with a spring or elastic stops in Joint::dof, also coupled joints
  std::vector<Spring> elements;  ///< the springs of the description, in its order
  /// The lines along which drives act, paths of two points in the order of the drives.
  std::vector<Spring::Path> drive_lines;

  bool empty() const { return joints.empty() && elements.empty(); }
  /// Whether a spring acts between frames, so that its force depends on the geometry of the mechanism.
  bool between_frames() const {
    return !std::all_of(elements.begin(), elements.end(), [](const Spring& s) { return s.on_joints(); });
  }
};

}  // namespace axode
