#pragma once
#include "axode/model/description.hpp"
#include "tests/support/random_tree.hpp"

namespace axode::test {

/// Without the armature of joints with several velocities.
inline Description with_simple_rotors(Description description) {
  for (BodyDescription& body : description.bodies)
    if (body.joint.kind == JointKind::spherical || body.joint.kind == JointKind::planar ||
        body.joint.kind == JointKind::free)
      for (Dof& dof : body.joint.dof) dof.armature = 0;
  return description;
}

}  // namespace axode::test
