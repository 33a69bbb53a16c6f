#pragma once
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "axode/model/description.hpp"

/// Reference poses: the poses (A, B, S_self) of every body of a description, whose geometry may be given in
/// three ways.
namespace axode {

/// Makes the rotation of a pose, which is exact to 1e-6, exact to working precision.
SE3<> orthonormal(const SE3<>& C);

/// The pose A⁻¹ B of B relative to A. No digits are lost if the two are near each other but far from the
/// origin.
SE3<> relative(const SE3<>& A, const SE3<>& B);

/// The name of the joint of a body: `<body>_joint` if it has no name of its own.
std::string joint_name(const BodyDescription& body);

/// Whether a body and its joint are drawn in the construction frame.
bool is_drawn(const BodyDescription& body);

/// The unit vector along an axis of any length but 0.
Vec3<> direction(const Vec3<>& axis);

/// The mechanism with cylindrical and universal joints replaced by chains of two joints through a massless
/// body.
Description expand(const Description& description);

/// The expanded mechanism with every joint described in joint frames, and every fixed body, frame and inertia
/// relative to a body frame, so that nothing depends on the pose of the predecessor. The description must
/// have no faults.
Description in_joint_frames(const Description& description);

/// Bodies in depth-first order, children as declared, and the index of each body's predecessor, -1 for the
/// ground. Bodies that do not hang on the ground (unknown predecessor, cycle) are left out of the order.
struct DepthFirstOrder {
  std::vector<int> order;
  std::vector<int> predecessor;
};
DepthFirstOrder depth_first_order(const Description& description);

/// The reference poses of a body and of its joint frame, at q = 0.
struct Placement {
  SE3<> A;       ///< body frame in the construction frame
  SE3<> B;       ///< body frame in the predecessor's
  SE3<> S_prev;  ///< joint frame in the predecessor's frame
  SE3<> S_self;  ///< joint frame in the body frame; its z-axis is the joint axis
  SE3<> J;       ///< joint frame in the construction frame
};
/// The placement of each body of an expanded description. Bodies that are not in the order have identity
/// poses.
///
/// The origin of the joint frame is the point of the joint. Its axes are those of the frame in which the axis
/// is given, turned the shortest way until z is the axis; a spherical joint keeps the axes of that frame, and
/// a free joint has the body frame. The joint frame of a fixed joint has no influence on the motion: it is
/// used as given; if it is not given and the body is drawn, it is the frame of the predecessor, because body
/// frames may be far away; otherwise it is the body frame. The position of a prismatic joint does not matter:
/// if the body is drawn far from the point of the joint (16 radii of gyration), the origin is the centre of
/// mass of the body or of its first successor with mass.
std::vector<Placement> reference_placements(const Description& expanded, const DepthFirstOrder& order);

/// The frames of a loop in the construction frame as it is drawn, and its size as in Loop::size.
struct DrawnLoop {
  std::array<SE3<>, 2> C;
  double size = 0;
};
/// The frames of a loop that is described without frames.
DrawnLoop drawn_loop(const LoopDescription& loop);
/// The size of a loop that is described with frames.
double size_of(const LoopDescription& loop);
/// The name of a loop or coupling: `loop 1` or `coupling 1` if it has no name of its own; k counts from 0.
std::string loop_name(const LoopDescription& loop, std::size_t k);
std::string coupling_name(const CouplingDescription& coupling, std::size_t k);
/// The name of a spring: `spring 1` if it has no name of its own; k counts from 0.
std::string spring_name(const SpringDescription& spring, std::size_t k);
/// The name of a spring for faults: `spring 1`, or `spring "strut"` if it has a name of its own.
std::string spring_element(const SpringDescription& spring, std::size_t k);
/// The name of a motion: `motion of <joint or rod>` if it has no name of its own.
std::string motion_name(const MotionDescription& motion);
/// The name of a drive: that in its description, or `drive k` with k from 1.
std::string drive_name(const DriveDescription& drive, std::size_t k);

/// The inertia `given` in the frame F, whose pose is relative to the frame in which the inertia is given. The
/// overload returns it in the joint frame J; it is given in the frame A, and the poses of J and A are
/// relative to the same frame. The inertia is transformed by way of the centre of mass, so that no digits are
/// lost far from the origin, unless it is given about that origin.
Inertia<> inertia_in(const SE3<>& F, const MassProperties& given);
Inertia<> inertia_in(const SE3<>& J, const SE3<>& A, const MassProperties& given);
/// The mass properties, given in the body frame, expressed in a frame S relative to the body frame.
MassProperties expressed_in(const SE3<>& S, const MassProperties& given);

/// Leaves the named joints out of the initial state, with a warning for each that was in it; `why` says what
/// has happened to the joint.
void leave_out_state(Description& description, const std::unordered_set<std::string>& joints,
                     const char* why);

}  // namespace axode
