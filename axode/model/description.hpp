#pragma once
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "axode/lie/inertia.hpp"
#include "axode/model/fault.hpp"

/// What an engineer says about a mechanism; ModelBuilder checks it and compiles it into a Model.
///
/// The mechanism is drawn with every joint at zero. Its one construction frame is the inertial frame, and the
/// body "ground" rests in it.
namespace axode {

enum class JointKind {
  fixed,
  revolute,
  prismatic,
  helical,
  cylindrical,  ///< becomes two joints, `<name>.rotation` and `<name>.translation`, through a massless body
  universal,    ///< becomes two joints, `<name>.first` and `<name>.second`, through a massless body
  spherical,
  planar,
  free,
};

/// What bounds and brakes one degree of freedom of a joint. Units by kind: rad or m, N m or N.
struct Dof {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double velocity = std::numeric_limits<double>::infinity();  ///< largest speed
  double effort = std::numeric_limits<double>::infinity();    ///< largest drive force
  double damping = 0;         ///< N m s/rad or N s/m; a force law, see Loads::joint_losses
  double friction = 0;        ///< Coulomb friction, N m or N; a force law, see Loads::joint_losses
  double armature = 0;        ///< kg m² or kg: inertia of the drive, felt at the joint; part of the dynamics
  double stiffness = 0;       ///< of a spring, N m/rad or N/m; acts in simulations, see spring_forces()
  double rest = 0;            ///< where the spring has no force, rad or m; 0 in joints of several velocities
  double stop_stiffness = 0;  ///< of stops at the limits, N m/rad or N/m; of joints of one velocity
  double stop_damping = 0;    ///< Hunt and Crossley's, s/rad or s/m
};

/// q = ratio q_leader + offset; a coupled joint has no coordinate of its own.
struct Coupling {
  std::string leader;
  double ratio = 1, offset = 0;
};

/// A joint between a body and its predecessor. Axis and point are given in the frame that the Geometry names.
struct JointDescription {
  std::string name = {};  ///< empty: `<body>_joint`
  JointKind kind = JointKind::fixed;
  Vec3<> axis{0, 0, 1};         ///< any length but 0; for planar the normal
  Vec3<> second_axis{1, 0, 0};  ///< of a universal joint, fixed in the child
  Vec3<> point{0, 0, 0};        ///< a point on the axis, the centre of a spherical or universal joint, m
  double pitch = 0;             ///< m/rad, of a helical joint
  std::vector<Dof> dof = {};    ///< one for each velocity, or empty
  std::optional<Coupling> coupling = {};  ///< of a revolute, prismatic or helical joint
  Source source = {};                     ///< where it differs from that of the body
};

/// Everything in the construction frame: axis and point are those of Y_i; A is the reference pose of the body
/// frame. Where nothing is said that is the construction frame itself, whose origin need not be on the body;
/// InConstructionFrame{{{}, point}} puts it at the joint, and `in` of MassProperties says where com is given.
struct InConstructionFrame {
  SE3<> A;
};
/// Axis and point in the body frame, as in X_i; B is the reference pose of the body frame in the
/// predecessor's.
struct InBodyFrame {
  SE3<> B;
};
/// Axis and point in the joint frame, as in Z_i; the joint frame has pose S_prev = S_{i-1,i} on the
/// predecessor and S_self = S_{i,i} on the body.
struct InJointFrames {
  SE3<> S_prev, S_self;
};
using Geometry = std::variant<InConstructionFrame, InBodyFrame, InJointFrames>;

enum class GivenIn { construction_frame, body_frame };
enum class InertiaAbout { center_of_mass, frame_origin };

/// Mass, centre of mass and rotational inertia of a body.
struct MassProperties {
  double mass = 0;                                    ///< kg
  Vec3<> com;                                         ///< m
  Sym3<> Theta;                                       ///< kg m²
  GivenIn in = GivenIn::body_frame;                   ///< frame of com and Theta
  InertiaAbout about = InertiaAbout::center_of_mass;  ///< reference point of Theta
  SO3<> axes = {};  ///< axes of Theta, rotated against that frame (the paper's R_bc)
};

/// A mesh that a file names; never opened.
struct MeshReference {
  enum class Role { visual, collision } role = Role::visual;
  std::string file;
  SE3<> pose;
  Vec3<> scale{1, 1, 1};
};

struct BodyDescription {
  std::string name;
  std::string predecessor = "ground";
  JointDescription joint = {};
  Geometry geometry = InConstructionFrame{};
  std::optional<MassProperties> inertia = {};  ///< none: massless
  std::vector<MeshReference> meshes = {};
  Source source = {};
};

/// A frame of interest on a body: a tool, a sensor, a contact point.
struct FrameDescription {
  std::string name;
  std::string body;
  SE3<> pose;
  GivenIn in = GivenIn::body_frame;
  Source source = {};
};

/// A spring and a damper along the line between points of two frames; act in simulations, see spring_forces().
struct SpringDescription {
  std::array<std::string, 2> between = {};  ///< bodies, named frames or "ground"
  std::array<Vec3<>, 2> points = {};        ///< m
  GivenIn in = GivenIn::body_frame;         ///< the points: each in its frame, or as drawn
  double stiffness = 0;                     ///< N/m
  double rest = 0;                          ///< length without a force, m
  double damping = 0;                       ///< N s/m
  Source source = {};
};

struct Description {
  std::string name = "mechanism";
  Vec3<> gravity{0, 0, -9.81};  ///< m/s²
  std::vector<BodyDescription> bodies;
  std::vector<FrameDescription> frames;
  std::vector<SpringDescription> springs = {};
  Source source = {};
  std::vector<Fault> warnings = {};  ///< what a reader found doubtful
};

}  // namespace axode
