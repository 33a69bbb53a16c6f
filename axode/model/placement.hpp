#pragma once
#include <span>
#include <vector>

#include "axode/model/description.hpp"

/// From the three ways in which geometry may be given to one, (A, B, S_self), for every body of a
/// description.
namespace axode {

/// A pose whose rotation is one to working precision, from one that is to 1e-6.
SE3<> orthonormal(const SE3<>& C);

/// A⁻¹ B: B seen from A. Where the two are near each other but far from the origin nothing is lost.
SE3<> relative(const SE3<>& A, const SE3<>& B);

/// The name of the joint of a body, `<body>_joint` where it has none of its own.
std::string joint_name(const BodyDescription& body);

/// Whether a body and its joint are drawn in the construction frame.
bool is_drawn(const BodyDescription& body);

/// The unit vector along an axis of any length but 0.
Vec3<> direction(const Vec3<>& axis);

/// The same mechanism with cylindrical and universal joints as chains of two joints through a massless body.
Description expand(const Description& description);

/// The same mechanism, expanded, with every joint in joint frames, every fixed body, frame and inertia relative to the
/// body frame: nothing depends on where its predecessor is. The description must be without faults.
Description in_joint_frames(const Description& description);

/// Bodies in depth-first order, children as declared, and the index of each body's predecessor, -1 for the
/// ground. Bodies that hang on no ground (an unknown predecessor, a cycle) are left out of the order.
struct DepthFirstOrder {
  std::vector<int> order;
  std::vector<int> predecessor;
};
DepthFirstOrder depth_first_order(const Description& description);

/// Where a body and its joint frame are at q = 0.
struct Placement {
  SE3<> A;       ///< body frame in the construction frame
  SE3<> B;       ///< body frame in the predecessor's
  SE3<> S_prev;  ///< joint frame in the predecessor's frame
  SE3<> S_self;  ///< joint frame in the body frame; its z-axis is the joint axis
  SE3<> J;       ///< joint frame in the construction frame
};
/// One for each body of an expanded description; those not in the order stay at the identity.
///
/// The joint frame has its origin in the joint's point and is turned the shortest way from the frame in which
/// the axis is given until its z-axis is the axis; for a spherical joint it keeps the axes of that frame, for
/// a free joint it is the body frame. That of a fixed one moves nothing: as given; of a drawn body that of its
/// predecessor, which is near where body frames may be far; else the body frame. No point matters to a prismatic joint: if the
/// body is drawn far from the joint's point (16 radii of gyration), the origin is its centre of mass, or that of the first successor
/// with mass.
std::vector<Placement> reference_placements(const Description& expanded, const DepthFirstOrder& order);

/// Where the frames of a loop are, as drawn in the construction frame, and its size as Loop::size has it.
struct DrawnLoop {
  std::array<SE3<>, 2> C;
  double size = 0;
};
/// Of a loop that is told without frames.
DrawnLoop drawn_loop(const LoopDescription& loop);
/// The size of one that is told with frames.
double size_of(const LoopDescription& loop);
/// Its name, `loop 1` or `coupling 1` where it has none of its own; k from 0.
std::string loop_name(const LoopDescription& loop, std::size_t k);
std::string coupling_name(const CouplingDescription& coupling, std::size_t k);

/// The inertia in the frame F, seen from the frame in which it is given; or in the frame J, where it is given in A and
/// both are seen from one frame. It goes by the centre of mass, so that nothing is lost where the origin in which it is
/// given is far away, unless it is the inertia about that origin.
Inertia<> inertia_in(const SE3<>& F, const MassProperties& given);
Inertia<> inertia_in(const SE3<>& J, const SE3<>& A, const MassProperties& given);
/// The same matter, given in the body frame, as one gives it in the frame S that is seen from that.
MassProperties expressed_in(const SE3<>& S, const MassProperties& given);

}  // namespace axode
