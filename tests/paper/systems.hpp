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
  double m;  ///< kg
  Vec3<> p;  ///< in the body frame, m
};

/// The joint frames on the predecessor and on the body, and the joint's screw in them.
struct JointFrames {
  SE3<> S_prev, S_self;
  Screw<> Z;
};

/// What the drawing says about a body. Screws are of joints that have one.
struct Drawn {
  Screw<> Y;                                ///< in the inertial frame, at q = 0
  std::optional<JointFrames> joint_frames;  ///< where they were drawn: any, not aligned with the axis
  std::vector<PointMass> points;            ///< all matter of the body
};

/// A mechanism with random body frames and joint frames. Each body is a few point masses and gives its
/// geometry and its inertia in another of the ways that there are; each has a frame "<body>.com" in its
/// centre of mass.
struct System {
  Topology topology;
  Model model;
  std::vector<Drawn> drawn;            ///< by body of the model; 0 is the ground
  std::vector<AppliedWrench<>> loads;  ///< in every representation
};

/// Which body frames a mechanism gets: random ones, or all of them at the construction frame, A_i = I
/// (section 4.4).
enum class BodyFrames { random, at_the_construction_frame };

/// The same mechanism for the same topology and seed, whatever the frames.
System make_system(Topology topology, std::uint64_t seed, BodyFrames frames = BodyFrames::random);

}  // namespace axode::test::paper
