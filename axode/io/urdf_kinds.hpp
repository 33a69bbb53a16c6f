#pragma once
#include <array>

#include "axode/model/joint_kinds.hpp"

namespace axode::io {

/// A type of joint of URDF and what it is here.
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

}  // namespace axode::io
