#pragma once
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "axode/lie/inertia.hpp"
#include "axode/model/fault.hpp"
#include "axode/model/loops.hpp"

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
  /// Whether it has no drive. If nothing is said it has one, but for free joints of mechanisms with loops or couplings.
  std::optional<bool> passive = {};
  Source source = {};  ///< where it differs from that of the body
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

enum class ShapeKind {
  box,
  sphere,
  cylinder,  ///< along z, about its middle
  capsule,   ///< a cylinder along z with a half ball on each end, about its middle
  ellipsoid,
  mesh,  ///< of a file, which is named and not opened
};

/// What a body looks like, or what it touches others with. Kept, written and drawn; no part of the dynamics.
struct ShapeDescription {
  enum class Role { visual, collision } role = Role::visual;
  std::string name = {};
  ShapeKind kind = ShapeKind::box;
  SE3<> pose = {};        ///< in the body frame; of the ground in the construction frame
  Vec3<> size{};          ///< edges of a box, semi-axes of an ellipsoid, m
  double radius = 0;      ///< m
  double length = 0;      ///< of a cylinder; of a capsule without its ends, m
  std::string file = {};  ///< of a mesh, as it was told: see find_mesh()
  Vec3<> scale{1, 1, 1};  ///< of a mesh: m for each of its units
  std::optional<std::array<double, 4>> color = {};  ///< red, green, blue, opacity; 0 to 1
};

struct BodyDescription {
  std::string name;
  std::string predecessor = "ground";
  JointDescription joint = {};
  Geometry geometry = InConstructionFrame{};
  std::optional<MassProperties> inertia = {};  ///< none: massless
  std::vector<ShapeDescription> shapes = {};
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

/// A joint that closes a loop. All is drawn at q = 0 in the construction frame, where the loop is closed, so axis and point
/// are enough; or the frame of the loop is given on either one of the two, which need not meet at q = 0.
struct LoopDescription {
  std::string name = {};  ///< empty: `loop 1`, ...; unlike those of joints
  std::array<std::string, 2> between =
      {};  ///< bodies, named frames or "ground"; its wrench acts on the second
  LoopKind kind = LoopKind::revolute;
  Vec3<> axis{0, 0, 1};               ///< any length but 0; for planar and rolling the normal of the plane
  Vec3<> second_axis{1, 0, 0};        ///< of a universal joint, fixed in the second
  Vec3<> point{};                     ///< on the axis; the centre; on the plane, m
  double pitch = 0;                   ///< m/rad, of a helical joint
  std::array<Vec3<>, 2> points = {};  ///< of a rod: on the first, on the second, m
  Vec3<> center{};                    ///< of what rolls, m
  std::optional<Vec3<>> wheel_axis = {};  ///< of a wheel that rolls; none: a sphere
  /// In place of all these: poses in the frames of the two. z is the axis and the origin the point; of a universal joint z
  /// is the first axis on the first and the second on the second; of a rod the origins are its ends; of what rolls z is the
  /// normal on the first, and on the second, whose origin is the centre, the axis of a wheel.
  std::optional<std::array<SE3<>, 2>> frames = {};
  std::optional<double> length = {};  ///< of a rod, m; none: as drawn
  std::optional<double> radius = {};  ///< of what rolls, m; none: as drawn
  std::optional<double> angle = {};   ///< between the axes of a universal joint, rad; none: as drawn
  Source source = {};
};

/// Σ factor q = offset, over joints of one velocity: a differential, a cable, a gear train. Closes a loop as well.
struct CouplingDescription {
  std::string name = {};                                   ///< empty: `coupling 1`, ...
  std::vector<std::pair<std::string, double>> terms = {};  ///< joints and their factors
  double offset = 0;
  Source source = {};
};

struct Description {
  std::string name = "mechanism";
  Vec3<> gravity{0, 0, -9.81};  ///< m/s²
  std::vector<BodyDescription> bodies;
  std::vector<FrameDescription> frames;
  std::vector<ShapeDescription> shapes = {};  ///< of the ground
  std::vector<SpringDescription> springs = {};
  std::vector<LoopDescription> loops = {};
  std::vector<CouplingDescription> couplings = {};
  Source source = {};
  std::vector<Fault> warnings = {};  ///< what a reader found doubtful
};

/// Whether a joint has no drive: as the description says or, if it says nothing, where the joint is a free one of a mechanism
/// with loops or couplings.
inline bool is_passive(const JointDescription& joint, const Description& d) {
  const bool closed = !(d.loops.empty() && d.couplings.empty());
  return joint.passive.value_or(closed && joint.kind == JointKind::free);
}

}  // namespace axode
