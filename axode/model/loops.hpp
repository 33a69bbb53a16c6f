#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "axode/model/description.hpp"

namespace axode {

/// The table of what closes loops: who needs to know something about a kind asks here.
struct LoopTraits {
  LoopKind kind;
  std::string_view name;
  int rows;       ///< of the Jacobian
  int residuals;  ///< fewer where velocities are bound and places are not
  bool axis;      ///< whether it is drawn with one; for planar and rolling the normal
  bool point;     ///< whether it matters where it is
};

inline constexpr std::array<LoopTraits, 12> loop_kinds{{
    {LoopKind::fixed, "fixed", 6, 6, false, false},
    {LoopKind::revolute, "revolute", 5, 5, true, true},
    {LoopKind::prismatic, "prismatic", 5, 5, true, false},
    {LoopKind::helical, "helical", 5, 5, true, true},
    {LoopKind::cylindrical, "cylindrical", 4, 4, true, true},
    {LoopKind::spherical, "spherical", 3, 3, false, true},
    {LoopKind::planar, "planar", 3, 3, true, true},
    {LoopKind::translational, "translational", 3, 3, false, false},
    {LoopKind::universal, "universal", 4, 4, true, true},
    {LoopKind::rod, "rod", 1, 1, false, false},
    {LoopKind::rolling, "rolling", 3, 1, true, true},
    {LoopKind::coupling, "coupling", 1, 1, false, false},
}};

constexpr const LoopTraits& traits(LoopKind kind) {
  return *std::find_if(loop_kinds.begin(), loop_kinds.end(),
                       [&](const LoopTraits& t) { return t.kind == kind; });
}
constexpr std::string_view to_string(LoopKind kind) { return traits(kind).name; }

/// A closed loop as the kernels read it, see loop_jacobian().
struct Loop {
  struct End {
    int body = 0;
    SE3<> F;  ///< the frame of the loop in the internal frame of that body
  };
  /// factor q[coordinate], of a coupling.
  struct Term {
    int coordinate, velocity;
    double factor;
  };
  std::string name;
  LoopKind kind{};
  std::array<End, 2> ends = {};
  double pitch = 0;  ///< m/rad, of a helical joint
  double size = 0;   ///< length of a rod, radius of what rolls, m; cosine of the angle between universal axes
  bool wheel = false;  ///< whether what rolls is a wheel
  std::vector<Term> terms = {};
  double offset = 0;  ///< Σ factor q = offset
  int first_row = 0, first_residual = 0;

  int rows() const { return traits(kind).rows; }
  int residuals() const { return traits(kind).residuals; }
};

/// All loops of a mechanism.
struct Loops {
  std::vector<Loop> all;
  int rows = 0, residuals = 0;  ///< of all together
  std::vector<char> driven;     ///< nv: whether a joint that is not passive has that velocity

  bool empty() const { return all.empty(); }
};

}  // namespace axode
