#pragma once
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "axode/model.hpp"
#include "axode/recursion/loads.hpp"

/// The mechanisms on which the paper's equations are evaluated.
namespace axode::test::paper {

enum class Topology {
  chain,            ///< 5 bodies; R, P and H joints
  tree,             ///< 9 bodies, three of them on the ground; R, P and H joints
  many_dof_joints,  ///< 8 bodies, two of them on the ground; also spherical, planar and free joints
};
std::string_view to_string(Topology topology);

struct PointMass {
  double m;  ///< mass, kg
  Vec3<> p;  ///< position in the body frame, m
};

/// The joint frames on the predecessor and on the body, and the joint's screw in these frames.
struct JointFrames {
  SE3<> S_prev, S_self;
  Screw<> Z;
};

/// The drawing of a body. The screws exist for joints that have one.
struct Drawn {
  Screw<> Y;                                ///< in the inertial frame, at q = 0
  std::optional<JointFrames> joint_frames;  ///< the joint frames, if they were drawn; they have any
                                            ///< orientation relative to the axis
  std::vector<PointMass> points;            ///< the masses of the body
};

/// A mechanism with random body frames and joint frames. Each body consists of a few point masses. The bodies
/// give their geometry and their inertia in the possible ways in turn. Each body has a frame "<body>.com" in
/// its centre of mass.
struct System {
  Topology topology;
  Model model;
  std::vector<Drawn> drawn;            ///< for each body of the model; 0 is the ground
  std::vector<AppliedWrench<>> loads;  ///< loads in every representation
};

/// The body frames of a mechanism: random ones, or all of them at the construction frame, A_i = I (section
/// 4.4).
enum class BodyFrames { random, at_the_construction_frame };

/// Makes the mechanism of a topology and a seed. It is the same mechanism for both choices of body frames.
System make_system(Topology topology, std::uint64_t seed, BodyFrames frames = BodyFrames::random);

}  // namespace axode::test::paper
