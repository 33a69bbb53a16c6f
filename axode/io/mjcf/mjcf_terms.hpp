#pragma once
#include <string>
#include <vector>

#include "axode/io/writing.hpp"
#include "axode/model/description.hpp"

/// Elements and attributes of MJCF, and faults for what MJCF cannot express.
namespace axode::io::mjcf {

/// ` name="value"`
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
bool has_words_for(const ShapeDescription& shape);

/// These add the properties of a joint and of shapes that MJCF cannot express to `unsaid`.
void joint_unsaid(const JointDescription& joint, const std::string& element, const Source& source,
                  Unsaid& unsaid);
void shapes_unsaid(const std::vector<ShapeDescription>& shapes, const std::string& owner,
                   const Source& source, Unsaid& unsaid);

}  // namespace axode::io::mjcf
