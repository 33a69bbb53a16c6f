#pragma once
#include <array>
#include <vector>

#include "axode/lie/vec3.hpp"

namespace axode {

/// The springs, dampers and stops of a mechanism as the kernels read them, see spring_forces().
struct Springs {
  /// A spring along the line between two points.
  struct Line {
    struct End {
      int frame = 0;
      Vec3<> point{};  ///< point in that frame, m
    };
    std::array<End, 2> ends;
    double stiffness = 0, rest = 0, damping = 0;
  };
  std::vector<int> joints;  ///< joints that have a spring or stops, coupled ones included; see Joint::dof
  std::vector<Line> lines;

  bool empty() const { return joints.empty() && lines.empty(); }
};

}  // namespace axode
