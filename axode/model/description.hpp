#pragma once
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "axode/lie/inertia.hpp"
#include "axode/model/building/fault.hpp"
#include "axode/model/kinds/drive_kinds.hpp"
#include "axode/model/loops.hpp"
#include "axode/model/springs.hpp"

/// The description of a mechanism as an engineer gives it. ModelBuilder checks it and compiles it into a
/// Model.
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

/// Limits, losses, drive inertia and elastic elements of one degree of freedom of a joint. Units follow from
/// the kind: rad or m, N m or N.
struct Dof {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double velocity = std::numeric_limits<double>::infinity();  ///< largest speed
  double effort = std::numeric_limits<double>::infinity();    ///< largest drive force
  double damping = 0;    ///< N m s/rad or N s/m; a force law, see Loads::joint_losses
  double friction = 0;   ///< Coulomb friction, N m or N; a force law, see Loads::joint_losses
  double armature = 0;   ///< inertia of the drive as it acts at the joint, kg m² or kg; part of the dynamics
  double stiffness = 0;  ///< stiffness of a spring, N m/rad or N/m; acts in simulations, see spring_forces()
  /// Position at which the spring has no force, rad or m; 0 for joints of several velocities.
  double rest = 0;
  /// Stiffness of stops at the limits, N m/rad or N/m; for joints of one velocity.
  double stop_stiffness = 0;
  double stop_damping = 0;  ///< damping of the stops by Hunt and Crossley, s/rad or s/m
  bool hard_stops = false;  ///< whether the limits are stops that do not yield; for joints of one velocity
  double restitution = 0;   ///< restitution of hard stops, 0 to 1
  /// The part of the force F that the gear transmits to the joint and that it loses in addition while the
  /// drive drives, an efficiency of 1/(1 + gear_loss); a force law, see Loads::joint_losses. For joints of
  /// one velocity.
  double gear_loss = 0;
  /// The same part while the joint drives the drive back. If empty, it is gear_loss. The efficiency is
  /// 1 - gear_loss_back, and from 1 on the gear locks itself.
  std::optional<double> gear_loss_back = {};
};
/// Whether the gear of a joint loses a part of the force that it transmits.
inline bool has_gear_losses(const Dof& dof) {
  return dof.gear_loss > 0 || dof.gear_loss_back.value_or(0) > 0;
}

/// q = ratio q_leader + offset; a coupled joint has no coordinate of its own.
struct Coupling {
  std::string leader;
  double ratio = 1, offset = 0;
};

/// A joint between a body and its predecessor. Axis and point are given in the frame that the Geometry names.
struct JointDescription {
  std::string name = {};  ///< empty: `<body>_joint`
  JointKind kind = JointKind::fixed;
  Vec3<> axis{0, 0, 1};         ///< axis of any length but 0; for planar joints the normal
  Vec3<> second_axis{1, 0, 0};  ///< second axis of a universal joint, fixed in the child
  Vec3<> point{0, 0, 0};        ///< a point on the axis, the centre of a spherical or universal joint, m
  double pitch = 0;             ///< pitch of a helical joint, m/rad
  std::vector<Dof> dof = {};    ///< one for each velocity, or empty
  std::optional<Coupling> coupling = {};  ///< coupling of a revolute, prismatic or helical joint
  /// Whether the joint has no drive. If empty, it has a drive unless it is a free joint of a mechanism with
  /// loops or couplings.
  std::optional<bool> passive = {};
  Source source = {};  ///< source of the joint if it differs from that of the body
};

/// Geometry in the construction frame: axis and point are those of Y_i; A is the reference pose of the body
/// frame. By default A is the construction frame itself, whose origin need not be on the body;
/// InConstructionFrame{{{}, point}} has the origin at the joint. `in` of MassProperties names the frame of
/// com.
struct InConstructionFrame {
  SE3<> A;
};
/// Geometry in the body frame: axis and point are those of X_i; B is the reference pose of the body frame in
/// the frame of the predecessor.
struct InBodyFrame {
  SE3<> B;
};
/// Geometry in joint frames: axis and point are those of Z_i; the joint frame has pose S_prev = S_{i-1,i} on
/// the predecessor and S_self = S_{i,i} on the body.
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
  mesh,   ///< mesh in a file, which is not opened here
  plane,  ///< the half-space z < 0, whose outward normal is z
};

/// The largest coefficient of friction of two shapes, as a number or in m; larger ones act like this one. A
/// surface must be steeper than 89.9 degrees for a shape to slide with it, and the numbers of a step with
/// contact still have digits for its laws.
inline constexpr double most_friction = 1000;

/// How the surface of a shape behaves in contact. Two shapes in contact have the geometric mean of their
/// coefficients of each kind of friction, and the larger of their restitutions. Surfaces with a stiffness are
/// compliant and act like springs in series; they do not bounce by a restitution.
struct ContactProperties {
  std::optional<double> friction = {};  ///< coefficient of sliding friction; empty: that of the mechanism
  double spin_friction = 0;             ///< moment of drilling friction divided by the normal force, m
  double rolling_friction = 0;          ///< moment of rolling friction divided by the normal force, m
  double restitution = 0;               ///< 0 to 1
  /// Stiffness k of the normal force k dⁿ (1 + c d') at a depth d of overlap, N/mⁿ; empty: a rigid surface
  std::optional<double> stiffness = {};
  double exponent = 1.5;  ///< n, 1 to 10
  double damping = 0;     ///< c, s/m
};

/// A visual shape of a body, or one for contacts. Shapes are kept, written and drawn; only simulations with
/// contact let collision shapes act.
struct ShapeDescription {
  enum class Role { visual, collision } role = Role::visual;
  std::string name = {};
  ShapeKind kind = ShapeKind::box;
  SE3<> pose = {};        ///< pose in the body frame, or in the construction frame for shapes of the ground
  Vec3<> size{};          ///< edges of a box, semi-axes of an ellipsoid, m
  double radius = 0;      ///< m
  double length = 0;      ///< length of a cylinder, or of a capsule without its ends, m
  std::string file = {};  ///< file of a mesh as the description gives it: see find_mesh()
  Vec3<> scale{1, 1, 1};  ///< scale of a mesh: m for each of its units
  std::optional<std::array<double, 4>> color = {};  ///< red, green, blue, opacity; 0 to 1
  ContactProperties contact = {};                   ///< used for collision shapes
};

struct BodyDescription {
  std::string name;
  std::string predecessor = "ground";
  JointDescription joint = {};
  Geometry geometry = InConstructionFrame{};
  std::optional<MassProperties> inertia = {};  ///< empty: the body is massless
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

/// A spring and a damper. Its kind says what it measures: a line between two points unless another kind is
/// given. It acts in simulations, see spring_forces().
struct SpringDescription {
  /// A point of a tendon on a body or a named frame, or on the ground.
  struct Point {
    std::string on;
    Vec3<> point{};  ///< m
  };
  std::string name = {};  ///< empty: `spring 1`, ...
  SpringKind kind = SpringKind::line;
  std::array<std::string, 2> between = {};  ///< bodies, named frames or "ground"; not for tendons and joints
  std::array<Vec3<>, 2> points = {};        ///< ends of a line, m
  /// Frame of points and poses: each in its frame, or all in the construction frame.
  GivenIn in = GivenIn::body_frame;
  double stiffness = 0;  ///< stiffness if no curve is given, N/m or N m/rad
  double rest = 0;       ///< coordinate of the deflection 0, m or rad; without a curve there is no force
  double damping = 0;    ///< N s/m or N m s/rad
  std::optional<ForceCurve> curve = {};  ///< the force by the deflection, in place of a stiffness
  Acts acts = Acts::both_ways;
  std::optional<double> preload = {};  ///< tension as drawn, in place of rest, N or N m
  std::vector<Point> path = {};        ///< points of a tendon
  std::array<SE3<>, 2> frames = {};    ///< frames of a bushing; of a torsion spring z is the axis
  std::vector<std::pair<std::string, double>> terms = {};  ///< joints and their factors
  SE3<> rest_pose = {};     ///< pose of the second frame of a bushing in the first one that has no wrench
  SixBySix K = {}, C = {};  ///< stiffness and damping of a bushing in the axes of its second frame
  Source source = {};
};

/// A joint that closes a loop. It is drawn by axis and point in the construction frame at q = 0, where the
/// loop is closed; or the frame of the loop is given on either body, and the two frames need not meet at q =
/// 0.
struct LoopDescription {
  std::string name = {};  ///< empty: `loop 1`, ...; must differ from names of joints
  /// Bodies, named frames or "ground". The wrench of the loop acts on the second one.
  std::array<std::string, 2> between = {};
  LoopKind kind = LoopKind::revolute;
  Vec3<> axis{0, 0, 1};         ///< axis of any length but 0; for planar and rolling the normal of the plane
  Vec3<> second_axis{1, 0, 0};  ///< second axis of a universal joint, fixed in the second body
  Vec3<> point{};               ///< point on the axis, centre, or point on the plane, m
  double pitch = 0;             ///< pitch of a helical joint, m/rad
  std::array<Vec3<>, 2> points = {};      ///< ends of a rod, or centres of the pulleys of a belt, m
  Vec3<> center{};                        ///< centre of the rolling body, m
  std::optional<Vec3<>> wheel_axis = {};  ///< axis of a rolling wheel; empty: the body is a sphere
  /// The alternative to a drawn loop: its poses in the frames of both bodies, whose z is the axis and whose
  /// origin is the point. For a universal joint z is the first axis on the first body and the second axis on
  /// the second one. For a rod the origins are its ends. For a rolling contact z is the normal on the first
  /// body; on the second one the origin is the centre, and z is the axis of a wheel. For a belt the origins
  /// are the centres of the pulleys, and z is the axis about which they turn.
  std::optional<std::array<SE3<>, 2>> frames = {};
  std::optional<double> length = {};  ///< length of a rod, m; empty: as drawn
  std::optional<double> radius = {};  ///< radius of a rolling body, m; empty: as drawn
  std::optional<double> angle = {};   ///< angle between the axes of a universal joint, rad; empty: as drawn
  std::array<double, 2> radii = {};   ///< radii of the pulleys of a belt, m; see Loop::radii for their signs
  Source source = {};
};

/// A coupling Σ factor q = offset of joints with one velocity: a differential, a cable or a gear train. It
/// closes a loop as well. With play it holds only at the ends of the play: |Σ factor q - offset| <= play/2.
struct CouplingDescription {
  std::string name = {};                                   ///< empty: `coupling 1`, ...
  std::vector<std::pair<std::string, double>> terms = {};  ///< joints and their factors
  double offset = 0;
  double play = 0;         ///< backlash from one side to the other, in units of the offset
  double restitution = 0;  ///< restitution of impacts at the ends of the play, 0 to 1
  Source source = {};
};

/// A function of time that a joint of one velocity or the length of a rod follows.
struct MotionDescription {
  std::string name = {};  ///< empty: that of its joint or rod
  std::string of;         ///< joint of one velocity, or loop of kind rod
  enum class Kind {
    harmonic,    ///< offset + amplitude sin(2π frequency t + phase)
    ramp,        ///< from `from` until `start` to `to` from `end` on, as a polynomial of degree 5
    polynomial,  ///< Σ coefficients[k] t^k
    samples,     ///< spline of degree 5 through (times, values)
  } kind = Kind::polynomial;
  double offset = 0, amplitude = 0, frequency = 0, phase = 0;  ///< rad or m, the same, Hz, rad
  double from = 0, to = 0, start = 0, end = 0;                 ///< rad or m, the same, s, s
  std::vector<double> coefficients = {};
  std::vector<double> times = {}, values = {};  ///< s, rad or m
  Source source = {};
};

/// The input of a drive: another drive, a function of time, or steps in time.
struct DriveInput {
  std::string from = {};                           ///< drive whose output it is; empty: none
  std::optional<MotionDescription> function = {};  ///< its name and joint are not used
  /// Otherwise it has the value k from times[k] on, and values[0] before. One value needs no time.
  std::vector<double> times = {}, values = {};
};

/// A drive with states of its own, see axode/drives.hpp. It acts in simulations: on a sum of joint
/// coordinates, or along a line between two points, whose ends a positive force pushes apart.
struct DriveDescription {
  std::string name = {};  ///< empty: `drive 1`, ...
  DriveKind kind = DriveKind::dc_motor;
  /// The joints of one velocity on which it acts, with their factors: its coordinate is Σ factor q. Empty if
  /// it acts along a line.
  std::vector<std::pair<std::string, double>> joints = {};
  struct Line {
    std::array<std::string, 2> between = {};  ///< bodies, named frames or "ground"
    std::array<Vec3<>, 2> points = {};        ///< m
    /// Frame of the points: each in its frame, or both in the construction frame.
    GivenIn in = GivenIn::body_frame;
  };
  std::optional<Line> line = {};
  /// Parameters by the names in drive_kinds. What is not named has its standard value.
  std::vector<std::pair<std::string, double>> parameters = {};
  /// Whether the integrator of a saturated PID controller stops, instead of following the limit.
  bool conditional = false;
  DriveInput input = {};
  /// Initial values of states by name. What is not named starts as the kind says.
  std::vector<std::pair<std::string, double>> initial = {};
  Source source = {};
};

/// Where a motion of the mechanism starts: coordinates and velocities of joints by name. What is not named is
/// 0, or the identity.
struct InitialStateDescription {
  std::vector<std::pair<std::string, std::vector<double>>> q = {}, v = {};
  Source source = {};
};

/// Settings of contact for the whole mechanism: the table [contact] of a drawing. Single shapes have their
/// own ContactProperties. A mechanism with these settings is simulated with contact unless another method is
/// named.
struct ContactDescription {
  double friction = 0.6;    ///< coefficient of sliding friction of shapes that have none of their own
  double margin = 0.01;     ///< gap below which a contact is considered, m
  double threshold = 0.05;  ///< speed of approach below which nothing bounces, m/s
  std::vector<std::array<std::string, 2>> ignored = {};  ///< pairs of bodies that never touch
  Source source = {};
};

struct Description {
  std::string name = "mechanism";
  Vec3<> gravity{0, 0, -9.81};  ///< m/s²
  std::vector<BodyDescription> bodies;
  std::vector<FrameDescription> frames;
  std::vector<ShapeDescription> shapes = {};  ///< shapes of the ground
  std::vector<SpringDescription> springs = {};
  std::vector<LoopDescription> loops = {};
  std::vector<CouplingDescription> couplings = {};
  std::vector<MotionDescription> motions = {};
  std::vector<DriveDescription> drives = {};
  std::optional<InitialStateDescription> state = {};
  std::optional<ContactDescription> contact = {};
  Source source = {};
  std::vector<Fault> warnings = {};  ///< warnings of the reader
};

/// Whether a joint has no drive: as the description says or, if it says nothing, if it is a free joint of a
/// mechanism with loops or couplings.
inline bool is_passive(const JointDescription& joint, const Description& d) {
  const bool closed = !(d.loops.empty() && d.couplings.empty());
  return joint.passive.value_or(closed && joint.kind == JointKind::free);
}

}  // namespace axode
