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

/// The kinds of springs, each with the quantity on which its force depends.
enum class SpringKind {
  line,     ///< the distance of two points
  tendon,   ///< the length of a path of points with straight segments
  torsion,  ///< the angle of two frames about an axis
  joints,   ///< Σ factor q of the coordinates of joints of one velocity
  bushing,  ///< the pose of one frame relative to another, with a stiffness for all six directions
};

/// The table of springs, with the keys of the drawing format by which a kind is placed. All kinds but
/// bushings have one coordinate and a ForceLaw.
struct SpringTraits {
  SpringKind kind;
  std::string_view name;
  std::string_view stiffness;  ///< unit of the stiffness, in words of the drawing format
  std::string_view damping;    ///< unit of the damping
  std::array<std::string_view, 5> keys;

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

/// A 6×6 matrix of numbers by its rows, angular before linear.
using SixBySix = std::array<std::array<double, 6>, 6>;

/// A spring and damper as the kernels read it, see spring_forces().
struct Spring {
  /// A path of two points or more. A spring along a line has two.
  struct Path {
    struct Point {
      int frame = 0;
      Vec3<> point{};  ///< point in that frame, m
    };
    std::vector<Point> points;
  };
  /// A pose on a frame.
  struct End {
    int frame = 0;
    SE3<> pose;
  };
  /// The angle about z of the two frames.
  struct Torsion {
    std::array<End, 2> ends;
  };
  /// Σ factor q + offset. The factor of a joint that follows another one has its ratio.
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
    SE3<> rest;     ///< pose of the second frame relative to the first one that has no wrench
    SixBySix K, C;  ///< stiffness and damping, symmetric
  };

  std::string name;
  std::variant<Path, Torsion, JointSum, Bushing> geometry;
  ForceLaw law = {};  ///< not used by bushings

  bool on_joints() const { return std::holds_alternative<JointSum>(geometry); }
};

/// The springs, dampers and stops of a mechanism.
struct Springs {
  std::vector<int> joints;  ///< joints that have a spring or stops, coupled ones included; see Joint::dof
  std::vector<Spring> elements;  ///< springs of the description, in its order
  /// Lines without forces along which drives act, in the order of the drives; each has two points.
  std::vector<Spring::Path> drive_lines;

  bool empty() const { return joints.empty() && elements.empty(); }
  /// Whether a spring acts between frames, so that its force depends on the geometry of the mechanism.
  bool between_frames() const {
    return !std::all_of(elements.begin(), elements.end(), [](const Spring& s) { return s.on_joints(); });
  }
};

}  // namespace axode
