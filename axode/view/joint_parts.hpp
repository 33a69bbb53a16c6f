#pragma once
#include <array>
#include <vector>

#include "axode/view/stand_ins.hpp"

namespace axode::view {

/// One of the two bodies at a joint.
struct JointSide {
  int body = 0;
  SE3<> pose;          ///< of the joint in the frame of the body; z is its axis
  bool drawn = false;  ///< whether a stand-in of the body reaches to the joint
  double radius = 0;   ///< of the bar of the body there, m
  double height = 0;   ///< of the bar above the point of the joint, along its axis, m
  Vec3<> towards;  ///< direction from the joint to the rest of the body in the frame of the joint, or zero
};

/// A joint as it is drawn.
struct DrawnJoint {
  Subgroup kind{};
  double pitch = 0;                ///< of a helical joint, m/rad
  double radius = 0;               ///< the size of its parts, m
  std::array<double, 4> color{};   ///< of the part that shows whether a drive moves it
  std::array<JointSide, 2> sides;  ///< the predecessor and the body, or both bodies of a loop joint
};

/// The shapes by which a joint is drawn. A hinge is a pin in a fork of the predecessor. In planar mechanisms
/// the bodies are drawn in layers, at different heights along the axis of the hinge; the pin then goes
/// through an eye of each body. A spherical joint is a ball in a socket, a helical joint a screw in a nut, a
/// planar joint a pad on a plate, and a prismatic joint a block. The fork, tongue, eye, socket, nut or plate
/// of a body is drawn only if a placeholder of the body, a shape that is drawn for a body without shapes of
/// its own, reaches to the joint. Free joints have no shapes.
std::vector<StandIn> parts_of(const DrawnJoint& joint);

}  // namespace axode::view
