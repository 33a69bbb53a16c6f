#pragma once
#include <optional>
#include <string>
#include <vector>

#include "axode/io/writing.hpp"
#include "axode/model/description.hpp"

/// Functions for elements and attributes of MJCF, and for faults about properties that MJCF cannot express.
namespace axode::io::mjcf {

/// attribute() returns the text of an attribute of XML, ` name="value"`. unless_zero() does so for a number,
/// and returns an empty text if it is 0.
std::string attribute(const char* name, const std::string& value);
std::string unless_zero(const char* name, double x);
/// The attributes pos and quat of a pose. The position is left out if it is 0, and the rotation if it is the
/// identity.
std::string pose_text(const SE3<>& pose);
/// The element <inertial> of a body, about the centre of mass and in the axes of the body. A is the pose of
/// the body frame in the inertial frame at q = 0.
std::string inertial_element(const MassProperties& given, const SE3<>& A);

bool in_mjcf(LoopKind kind);
/// The degrees of freedom of a joint with the numbers that MJCF can express; all other numbers are 0 or
/// infinite. A planar joint becomes a hinge and two slides in MJCF; each of the three has its own limits and
/// effort, but the slides must have the same losses and armature. A ball or free joint has one set of numbers
/// for all its degrees of freedom.
std::vector<Dof> said(const JointDescription& joint);
/// Whether MJCF can express a spring. It can if the spring acts along a path of points with a linear law,
/// without preload and in both directions; it becomes a spatial tendon.
bool has_words_for(const SpringDescription& spring);
/// Whether MJCF can express a shape of the ground (if `on_ground`) or of a body.
bool has_words_for(const ShapeDescription& shape, bool on_ground);
/// size_text() returns the attributes of a geom for the type and size of a shape that is no mesh.
/// friction_text() returns those for its friction; a shape without a coefficient of sliding friction gets
/// that of `contact`, the settings of the mechanism.
std::string size_text(const ShapeDescription& shape);
std::string friction_text(const ShapeDescription& shape, const std::optional<ContactDescription>& contact);

/// The following functions add a fault to `unsaid` (the list of what the writer leaves out) for each property
/// of joints, shapes, springs, couplings or contact that MJCF cannot express.
void joint_unsaid(const JointDescription& joint, const std::string& element, const Source& source,
                  Unsaid& unsaid);
void shapes_unsaid(const std::vector<ShapeDescription>& shapes, const std::string& owner, bool on_ground,
                   const Source& source, Unsaid& unsaid);
void springs_and_couplings_unsaid(const Description& d, Unsaid& unsaid);
void contact_unsaid(const std::optional<ContactDescription>& contact, Unsaid& unsaid);

}  // namespace axode::io::mjcf
