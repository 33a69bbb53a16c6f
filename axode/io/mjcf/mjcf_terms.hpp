#pragma once
#include <optional>
#include <string>
#include <vector>

#include "axode/io/writing.hpp"
#include "axode/model/description.hpp"

/// Elements and attributes of MJCF, and faults for what MJCF cannot express.
namespace axode::io::mjcf {

/// The text of an attribute: ` name="value"`.
std::string attribute(const char* name, const std::string& value);
std::string unless_zero(const char* name, double x);
/// The attributes pos and quat of a pose. The position is left out if it is 0, and the rotation if it is the
/// identity.
std::string pose_text(const SE3<>& pose);
/// The element of an inertia, about the centre of mass and in the axes of the body; its frame is drawn at A.
std::string inertial_element(const MassProperties& given, const SE3<>& A);

bool in_mjcf(LoopKind kind);
/// The degrees of freedom of a joint as MJCF can express them. Hinges and slides have numbers of their own,
/// but the two slides of a planar joint share losses, armature and effort; a ball or free joint has one set
/// of numbers for all. Numbers that MJCF cannot express are 0 or infinite.
std::vector<Dof> said(const JointDescription& joint);
/// Whether MJCF can express a spring: it is a spatial tendon with a linear law.
bool has_words_for(const SpringDescription& spring);
/// Whether MJCF can express a shape of the ground or of a body.
bool has_words_for(const ShapeDescription& shape, bool on_ground);
/// The attributes of a geom for the size of a shape that is no mesh, with its type, and for its friction.
/// Coefficients of sliding friction that the shape does not have are those of `contact`.
std::string size_text(const ShapeDescription& shape);
std::string friction_text(const ShapeDescription& shape, const std::optional<ContactDescription>& contact);

/// Adds the properties of a joint, and below those of shapes, that MJCF cannot express to `unsaid`.
void joint_unsaid(const JointDescription& joint, const std::string& element, const Source& source,
                  Unsaid& unsaid);
void shapes_unsaid(const std::vector<ShapeDescription>& shapes, const std::string& owner, bool on_ground,
                   const Source& source, Unsaid& unsaid);
void springs_and_couplings_unsaid(const Description& d, Unsaid& unsaid);
void contact_unsaid(const std::optional<ContactDescription>& contact, Unsaid& unsaid);

}  // namespace axode::io::mjcf
