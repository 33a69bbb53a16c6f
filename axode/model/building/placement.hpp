#pragma once
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "axode/model/description.hpp"

/// Computes the poses of all bodies and joint frames of a description at q = 0. A description may give the
/// geometry of a body in three ways. In the construction frame (the inertial frame in which the mechanism is
/// drawn) it gives the pose of the body and the axis and point of its joint. In body frames it gives the pose
/// of the body relative to its predecessor, and the axis and point in the frame of the body. In joint frames
/// it gives the poses of the joint frame relative to the predecessor and relative to the body, and the axis
/// and point in the joint frame.
namespace axode {

/// The pose with its rotation matrix, orthonormal to 1e-6, made orthonormal to working precision.
SE3<> orthonormal(const SE3<>& C);

/// The pose A⁻¹ B of B relative to A. No digits are lost far from the origin.
SE3<> relative(const SE3<>& A, const SE3<>& B);

/// The name of the joint of a body: `<body>_joint` if it has no name of its own.
std::string joint_name(const BodyDescription& body);

/// Whether the geometry of a body and its joint is given in the construction frame.
bool is_drawn(const BodyDescription& body);

/// The unit vector along an axis of any length but 0.
Vec3<> direction(const Vec3<>& axis);

/// The description with every cylindrical or universal joint split in two, and with names for all joints.
Description expand(const Description& description);

/// Changes a description such that every joint is given by its joint frames on its two bodies, and all other
/// elements relative to bodies and named frames. Cylindrical and universal joints are split in two. The
/// description must have no faults.
Description in_joint_frames(const Description& description);

/// The indices of the bodies of a description in depth-first order, with the children of a body in the order
/// of the description, and for each body the index of its predecessor, -1 for the ground. Bodies without a
/// path to the ground are not in `order`.
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
/// The poses of each body and its joint frame at q = 0. The description must have no cylindrical or universal
/// joints; bodies without a path to the ground get identity poses.
///
/// The origin of the joint frame is the point that the description gives for the joint. Its axes are those of
/// the frame in which the axis is given, turned the shortest way until z is the axis. A spherical joint keeps
/// the axes of that frame, and the joint frame of a free joint is the body frame.
///
/// The joint frame of a fixed joint has no influence on the motion. If the body is described by joint frames,
/// the described frame is taken. If the body is described in the construction frame (the inertial frame at q
/// = 0) and its predecessor is not the ground, the joint frame of the predecessor is taken, because the frame
/// of such a body may be far from the body. Otherwise the body frame is taken.
///
/// The point of a prismatic joint has no influence on the motion either. If a body that is described in the
/// construction frame has its centre of mass further away from this point than 16 radii of gyration, the
/// origin of the joint frame is the centre of mass. A body without mass takes the centre of mass and radius
/// of gyration of its first descendant that has mass and is described in the construction frame.
std::vector<Placement> reference_placements(const Description& expanded, const DepthFirstOrder& order);

/// The two joint frames of a loop in the construction frame at q = 0, and its size as in Loop::size.
struct DrawnLoop {
  std::array<SE3<>, 2> C;
  double size = 0;
};
/// The joint frames and size of a loop that is drawn: LoopDescription::frames must be empty.
DrawnLoop drawn_loop(const LoopDescription& loop);
/// The size, as in Loop::size, of a loop whose joint frames are given by LoopDescription::frames.
double size_of(const LoopDescription& loop);
/// The name of loop or coupling k in the description; without one, `loop <k + 1>` or `coupling <k + 1>`.
std::string loop_name(const LoopDescription& loop, std::size_t k);
std::string coupling_name(const CouplingDescription& coupling, std::size_t k);
/// The name of a spring with the index k in the description; `spring <k + 1>` if it has no name of its own.
std::string spring_name(const SpringDescription& spring, std::size_t k);
/// How messages call the spring with the index k: `spring "strut"`, or `spring <k + 1>` if it has no name.
std::string spring_element(const SpringDescription& spring, std::size_t k);
/// The name of a motion: `motion of <joint or rod>` if it has no name of its own.
std::string motion_name(const MotionDescription& motion);
/// The name of a drive with the index k in the description; `drive <k + 1>` if it has no name of its own.
std::string drive_name(const DriveDescription& drive, std::size_t k);

/// Returns the inertia about the origin and in the axes of a new frame, from mass properties in the frame of
/// `given`. F is the pose of the new frame in the frame of `given`. Alternatively J and A are the poses of
/// the new frame and of the frame of `given` in a third frame; no digits are lost if both are far from its
/// origin.
Inertia<> inertia_in(const SE3<>& F, const MassProperties& given);
Inertia<> inertia_in(const SE3<>& J, const SE3<>& A, const MassProperties& given);
/// Mass properties in the frame with the pose S in the body frame, from those in the body frame.
MassProperties expressed_in(const SE3<>& S, const MassProperties& given);

/// Removes joints from the initial state of a description, with a warning for each, which ends in `why`.
void leave_out_state(Description& description, const std::unordered_set<std::string>& joints,
                     const char* why);

}  // namespace axode
