#pragma once
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/io/writing.hpp"
#include "axode/model/description.hpp"

/// Functions for elements and attributes of MJCF, and for faults about properties that MJCF cannot express.
namespace axode::io::mjcf {

/// The text ` name="value"` of an XML attribute; unless_zero() returns an empty text for the number 0.
std::string attribute(const char* name, const std::string& value);
std::string unless_zero(const char* name, double x);
/// The attributes pos and quat of a pose. A zero position and an identity rotation are left out.
std::string pose_text(const SE3<>& pose);
/// Makes the element <inertial> of a body, about the centre of mass and in the axes of the body. A is the
/// pose of the body frame in the world frame at q = 0; it is needed if the mass properties are given in the
/// world frame.
std::string inertial_element(const MassProperties& given, const SE3<>& A);

/// A joint of MJCF: its type, what its name ends with after that of the joint of the description, the axis of
/// the joint frame along which it moves, and the degree of freedom that it has.
struct JointPart {
  std::string_view type, ending;
  int axis, dof;
};
/// The joints of MJCF that a joint becomes in one body, and its first degree of freedom of those that need
/// equal losses and armatures: a ball or free joint has one number for each property, and the two slides of a
/// planar joint do not turn with its angle as its velocities do.
struct JointInMjcf {
  JointKind kind;
  std::array<JointPart, 3> parts;
  std::size_t first_shared = 0;

  std::span<const JointPart> used_parts() const {
    return {parts.begin(), std::ranges::find(parts, "", &JointPart::type)};
  }
  bool is_ball() const { return parts[0].type == "ball"; }
  bool has_several_parts() const { return used_parts().size() > 1; }
};
/// Null if MJCF has no such joint.
const JointInMjcf* in_mjcf(JointKind kind);
bool in_mjcf(LoopKind kind);
/// A copy of the degrees of freedom of a joint of a kind that MJCF has. Every property that MJCF cannot
/// express for this kind of joint is 0 in it or, for limits, infinite.
std::vector<Dof> said(const JointDescription& joint);
/// Whether MJCF can express a spring, as a spatial tendon: a linear spring without preload that acts in both
/// directions, between two points or along a path of points on bodies.
bool has_words_for(const SpringDescription& spring);
/// Whether MJCF can express a shape of the ground (if `on_ground`) or of a body.
bool has_words_for(const ShapeDescription& shape, bool on_ground);
/// size_text() returns the attributes of a geom (MJCF's word for a shape) for the type and the size of a
/// shape that is not a mesh. friction_text() returns its attributes for friction; a shape without friction of
/// its own has that of `contact`, the settings of the mechanism.
std::string size_text(const ShapeDescription& shape);
std::string friction_text(const ShapeDescription& shape, const std::optional<ContactDescription>& contact);

/// These functions add to `unsaid`, the list of what MJCF cannot express, a fault for each such property.
void joint_unsaid(const JointDescription& joint, const std::string& element, const Source& source,
                  Unsaid& unsaid);
void shapes_unsaid(const std::vector<ShapeDescription>& shapes, const std::string& owner, bool on_ground,
                   const Source& source, Unsaid& unsaid);
void springs_and_couplings_unsaid(const Description& d, Unsaid& unsaid);
void contact_unsaid(const std::optional<ContactDescription>& contact, Unsaid& unsaid);

}  // namespace axode::io::mjcf
