#pragma once
#include <array>

#include "axode/model/kinds/joint_kinds.hpp"
#include "axode/model/loops.hpp"

namespace axode::io {

/// A type of joint in URDF, and the kind of joint that it becomes.
struct UrdfKind {
  std::string_view type;
  JointKind kind;
};
inline constexpr std::array<UrdfKind, 6> urdf_kinds{{{"revolute", JointKind::revolute},
                                                     {"continuous", JointKind::revolute},  // without limits
                                                     {"prismatic", JointKind::prismatic},
                                                     {"fixed", JointKind::fixed},
                                                     {"floating", JointKind::free},
                                                     {"planar", JointKind::planar}}};

/// Whether an element <loop_joint> with its two frames describes a loop of this kind completely.
constexpr bool in_urdf(LoopKind kind) {
  const std::array<std::string_view, 5>& keys = traits(kind).keys;
  return std::all_of(keys.begin(), keys.end(),
                     [](std::string_view key) { return key.empty() || key == "axis" || key == "point"; });
}

}  // namespace axode::io
