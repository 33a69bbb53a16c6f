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
#include "axode/model/kinds/joint_kinds.hpp"
#include "axode/model/loops.hpp"
#include "axode/model/springs.hpp"

/// The description of a mechanism, which ModelBuilder checks and compiles into a Model.
///
/// The mechanism is drawn with every joint at zero in the construction frame, which is the inertial frame;
/// the body "ground" rests in it.
namespace axode {

/// Limits, losses, drive inertia and elastic elements of one degree of freedom of a joint. If a member has
/// two units, the first one is for an angle and the second one for a length; forces are in N m or N. Losses
/// (damping, friction and gear losses) act only in computations for which the caller sets
/// Loads::joint_losses.
struct Dof {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double velocity = std::numeric_limits<double>::infinity();  ///< largest speed
  double effort = std::numeric_limits<double>::infinity();    ///< largest drive force
  double damping = 0;    ///< N m s/rad or N s/m; needs Loads::joint_losses
  double friction = 0;   ///< Coulomb friction, N m or N; needs Loads::joint_losses
  double armature = 0;   ///< inertia of the drive as it acts at the joint, kg m² or kg
  double stiffness = 0;  ///< stiffness of a spring, N m/rad or N/m; acts in simulations, see spring_forces()
  /// Position at which the spring has no force, rad or m. It must be 0 for joints of several velocities.
  double rest = 0;
  /// Stiffness of elastic stops at the limits, N m/rad or N/m. Only joints of one velocity can have stops.
  double stop_stiffness = 0;
  double stop_damping = 0;  ///< damping of elastic stops after Hunt and Crossley, s/rad or s/m
  bool hard_stops = false;  ///< whether the limits are rigid stops; for joints of one velocity
  double restitution = 0;   ///< coefficient of restitution of hard stops, 0 to 1
  /// Loss of the gear while the drive drives the joint, divided by the force F that the gear transmits: the
  /// drive needs the force (1 + gear_loss) F, so that the efficiency is 1/(1 + gear_loss). Only joints of one
  /// velocity can have a gear.
  double gear_loss = 0;
  /// Loss of the gear while the joint drives the drive back, divided by the force that the gear transmits. If
  /// it is empty, gear_loss is used. The efficiency is 1 - gear_loss_back; a gear with 1 or more cannot be
  /// driven back (it locks itself).
  std::optional<double> gear_loss_back = {};
};
/// Whether the gear of a joint loses a part of the force that it transmits.
inline bool has_gear_losses(const Dof& dof) {
  return dof.gear_loss > 0 || dof.gear_loss_back.value_or(0) > 0;
}

/// The coupling of a joint to another one, its leader: q = ratio q_leader + offset. A coupled joint has no
/// coordinate of its own.
struct Coupling {
  std::string leader;
  double ratio = 1, offset = 0;
};

/// A joint of a body on its predecessor; BodyDescription::geometry tells the frame of its axis and point.
struct JointDescription {
  std::string name = {};  ///< empty: `<body>_joint`
  JointKind kind = JointKind::fixed;
  Vec3<> axis{0, 0, 1};         ///< axis of any length but 0; for planar joints the normal
  Vec3<> second_axis{1, 0, 0};  ///< second axis of a universal joint, fixed in the child
  Vec3<> point{0, 0, 0};        ///< a point on the axis, the centre of a spherical or universal joint, m
  double pitch = 0;             ///< pitch of a helical joint, m/rad
  std::vector<Dof> dof = {};    ///< one for each degree of freedom, or empty
  std::optional<Coupling> coupling = {};  ///< coupling of a revolute, prismatic or helical joint
  /// Whether the joint has no drive; by default only a free joint of a mechanism with loops or couplings.
  std::optional<bool> passive = {};
  Source source = {};  ///< place in a file; empty if it is that of the body
};

/// Geometry of a body in the construction frame, the inertial frame in which the mechanism is drawn at q = 0.
/// The axis and the point of its joint are given in this frame and determine the spatial screw Y_i of the
/// joint. A is the pose of the body frame at q = 0. By default A is the identity.
struct InConstructionFrame {
  SE3<> A;
};
/// Geometry of a body in the body frame. The axis and the point of its joint are given in this frame and
/// determine the body-fixed screw X_i of the joint. B is the pose of the body frame in the frame of the
/// predecessor at q = 0.
struct InBodyFrame {
  SE3<> B;
};
/// Geometry of a body in joint frames. The axis and the point of its joint are given in the joint frame and
/// determine the screw Z_i of the joint. At q = 0 the joint frame has the pose S_prev = S_{i-1,i} in the
/// frame of the predecessor and S_self = S_{i,i} in the frame of the body.
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
  SO3<> axes = {};  ///< axes of Theta relative to the frame `in` (the paper's R_bc)
};

enum class ShapeKind {
  box,
  sphere,
  cylinder,  ///< along z, about its middle
  capsule,   ///< a cylinder along z with a half ball on each end, about its middle
  ellipsoid,
  mesh,   ///< mesh in a file; the builder does not open it
  plane,  ///< the half-space z < 0, whose outward normal is z
};

/// The largest coefficient of friction in a contact: a number for sliding friction, in m for drilling and
/// rolling friction. Larger coefficients are replaced by this one, because the equations of contact could not
/// be solved with sufficient accuracy.
inline constexpr double most_friction = 1000;

/// How the surface of a shape behaves in contact. Two shapes in contact have as their coefficient of each
/// kind of friction the geometric mean of both coefficients, and as their restitution the larger one.
/// Surfaces with a stiffness are compliant and act like springs in series; for them the restitution has no
/// meaning.
struct ContactProperties {
  std::optional<double> friction = {};  ///< sliding friction; empty: that of ContactDescription
  double spin_friction = 0;             ///< moment of drilling friction divided by the normal force, m
  double rolling_friction = 0;          ///< moment of rolling friction divided by the normal force, m
  double restitution = 0;               ///< 0 to 1
  /// Stiffness k of the normal force k dⁿ (1 + c d') at a depth d of overlap, N/mⁿ; empty: a rigid surface
  std::optional<double> stiffness = {};
  double exponent = 1.5;  ///< n, 1 to 10
  double damping = 0;     ///< c, s/m
};

/// A shape of a body or of the ground, for drawing (visual) or for contacts (collision). Only contacts of
/// collision shapes have an influence on the dynamics.
struct ShapeDescription {
  enum class Role { visual, collision } role = Role::visual;
  std::string name = {};
  ShapeKind kind = ShapeKind::box;
  SE3<> pose = {};        ///< pose in the body frame, or in the construction frame for shapes of the ground
  Vec3<> size{};          ///< edge lengths of a box or semi-axes of an ellipsoid, m
  double radius = 0;      ///< m
  double length = 0;      ///< length of a cylinder, or of a capsule without its ends, m
  std::string file = {};  ///< file of a mesh as the description gives it: see find_mesh()
  Vec3<> scale{1, 1, 1};  ///< scale of a mesh along x, y and z, m per unit of the file
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

/// A named frame on a body, such as that of a tool, a sensor or a contact point.
struct FrameDescription {
  std::string name;
  std::string body;
  SE3<> pose;
  GivenIn in = GivenIn::body_frame;
  Source source = {};
};

/// A spring and a damper in parallel. Its kind determines the coordinate (a length or an angle) on which the
/// force depends; for the default kind this is the distance of two points. Simulations, linearisations and
/// equilibria take the forces of springs into account; inverse and forward dynamics leave them out.
struct SpringDescription {
  /// A point of a tendon. `on` is the name of a body, of a named frame, or "ground".
  struct Point {
    std::string on;
    Vec3<> point{};  ///< m
  };
  std::string name = {};  ///< empty: `spring 1`, ...
  SpringKind kind = SpringKind::line;
  std::array<std::string, 2> between = {};  ///< bodies, named frames or "ground"; not for tendons and joints
  std::array<Vec3<>, 2> points = {};        ///< ends of a line, m
  /// The frame in which `points`, `path` and `frames` are given: body_frame is the frame of the body, or the
  /// named frame, to which each of them is fixed; construction_frame is the inertial frame at q = 0.
  GivenIn in = GivenIn::body_frame;
  double stiffness = 0;                  ///< stiffness if no curve is given, N/m or N m/rad
  double rest = 0;                       ///< coordinate at which the deflection is 0, m or rad
  double damping = 0;                    ///< N s/m or N m s/rad
  std::optional<ForceCurve> curve = {};  ///< force as a function of the deflection; replaces `stiffness`
  Acts acts = Acts::both_ways;
  std::optional<double> preload = {};  ///< tension at q = 0, N or N m; replaces `rest`
  std::vector<Point> path = {};        ///< points of a tendon
  std::array<SE3<>, 2> frames = {};    ///< frames of a bushing or torsion spring; z is the axis of torsion
  std::vector<std::pair<std::string, double>> terms = {};  ///< joints and their factors
  SE3<> rest_pose = {};     ///< pose of the second frame of a bushing in the first one without a wrench
  SixBySix K = {}, C = {};  ///< stiffness and damping of a bushing in the axes of its second frame
  Source source = {};
};

/// A joint that closes a loop. It is given by axis and point in the construction frame (the inertial frame),
/// if the loop is closed at q = 0, or else by its joint frames on the two bodies.
struct LoopDescription {
  std::string name = {};  ///< empty: `loop 1`, ...; must differ from the names of joints
  /// The two bodies that the loop joint connects: names of bodies or of named frames, or "ground". The wrench
  /// of the loop acts on the second body, and the opposite wrench on the first body.
  std::array<std::string, 2> between = {};
  LoopKind kind = LoopKind::revolute;
  Vec3<> axis{0, 0, 1};         ///< axis of any length but 0; for planar and rolling the normal of the plane
  Vec3<> second_axis{1, 0, 0};  ///< second axis of a universal joint, fixed in the second body
  Vec3<> point{};               ///< point on the axis, centre, or point on the plane, m
  double pitch = 0;             ///< pitch of a helical joint, m/rad
  std::array<Vec3<>, 2> points = {};      ///< ends of a rod, or centres of the pulleys of a belt, m
  Vec3<> center{};                        ///< centre of the rolling body, m
  std::optional<Vec3<>> wheel_axis = {};  ///< axis of a rolling wheel; empty: the body is a sphere
  /// The joint frames in the frames of the two bodies, instead of axis and point. The z-axis is the joint
  /// axis and the origin is the point, except:
  ///   - universal joint: z is the first axis in the first frame, and the second axis in the second frame;
  ///   - rod (keeps two points at a fixed distance): the origins are these points;
  ///   - rolling contact: z of the first frame is the normal of the plane, the origin of the second frame is
  ///     the centre of the rolling body, and z of the second frame is its axis if it is a wheel;
  ///   - belt: the origins are the centres of the pulleys, and z is the axis about which they turn.
  std::optional<std::array<SE3<>, 2>> frames = {};
  std::optional<double> length = {};  ///< length of a rod, m; empty: the distance of `points`
  std::optional<double> radius = {};  ///< radius of a rolling body, m; empty: it follows from `center`
  std::optional<double> angle = {};   ///< angle of the axes of a universal joint, rad; empty: as drawn
  std::array<double, 2> radii = {};   ///< radii of the pulleys of a belt, m; see Loop::radii for their signs
  Source source = {};
};

/// A coupling Σ factor q = offset of the coordinates q of joints with one degree of freedom each: a
/// differential, a cable or a gear train. With a positive `play` it only requires |Σ factor q - offset| <=
/// play/2.
struct CouplingDescription {
  std::string name = {};                                   ///< empty: `coupling 1`, ...
  std::vector<std::pair<std::string, double>> terms = {};  ///< joints and their factors
  double offset = 0;
  double play = 0;         ///< whole width of the backlash, in units of the offset
  double restitution = 0;  ///< restitution of impacts at the ends of the play, 0 to 1
  Source source = {};
};

/// A prescribed motion: a joint coordinate, or the length of a rod, as a function of time.
struct MotionDescription {
  std::string name = {};  ///< empty: `motion of <joint or rod>`
  std::string of;         ///< joint of one velocity, or loop of kind rod
  enum class Kind {
    harmonic,    ///< offset + amplitude sin(2π frequency t + phase)
    ramp,        ///< `from` until `start`, `to` after `end`, a polynomial of degree 5 in between
    polynomial,  ///< Σ coefficients[k] t^k
    samples,     ///< spline of degree 5 through (times, values)
  } kind = Kind::polynomial;
  double offset = 0, amplitude = 0, frequency = 0, phase = 0;  ///< rad or m, rad or m, Hz, rad
  double from = 0, to = 0, start = 0, end = 0;                 ///< rad or m, rad or m, s, s
  std::vector<double> coefficients = {};
  std::vector<double> times = {}, values = {};  ///< s, rad or m
  Source source = {};
};

/// The input of a drive: the output of another drive (`from`), a function of time, or values that change in
/// steps. All members are empty for a drive of a kind without input, such as friction.
struct DriveInput {
  std::string from = {};                           ///< name of the drive whose output is the input, or empty
  std::optional<MotionDescription> function = {};  ///< function of time; its `name` and `of` are not used
  /// Steps: the input is values[k] from times[k] on, and values[0] before; one value for a constant.
  std::vector<double> times = {}, values = {};
};

/// A drive with states of its own (currents, temperatures, ...), which acts in simulations. It acts on a sum
/// of joint coordinates, or along the line between two points; a positive force pushes the two points apart.
struct DriveDescription {
  std::string name = {};  ///< empty: `drive 1`, ...
  DriveKind kind = DriveKind::dc_motor;
  /// The joints on which the drive acts, each with its factor in the drive's coordinate Σ factor q. Each
  /// joint must have one degree of freedom. Empty if the drive acts along a line.
  std::vector<std::pair<std::string, double>> joints = {};
  struct Line {
    std::array<std::string, 2> between = {};  ///< bodies, named frames or "ground"
    std::array<Vec3<>, 2> points = {};        ///< m
    /// The frame in which `points` are given: body_frame is the frame of the body, or the named frame, to
    /// which each point is fixed; construction_frame is the inertial frame at q = 0.
    GivenIn in = GivenIn::body_frame;
  };
  std::optional<Line> line = {};
  /// Parameters by name, see drive_kinds for the names. A parameter that is not given has its standard value.
  std::vector<std::pair<std::string, double>> parameters = {};
  /// The anti-windup of a PID controller whose output is limited. If true, the integrator stops while the
  /// output is at its limit and the error would push it further. If false, the integrator is driven back
  /// until the output without the limit equals the limit (back calculation).
  bool conditional = false;
  DriveInput input = {};
  /// Initial values of states by name; other states start at the default of the kind of drive.
  std::vector<std::pair<std::string, double>> initial = {};
  Source source = {};
};

/// The initial state of the mechanism: q and v of joints by name. Other joints start at zero and at rest.
struct InitialStateDescription {
  std::vector<std::pair<std::string, std::vector<double>>> q = {}, v = {};
  Source source = {};
};

/// Settings of contact for the whole mechanism; those of single shapes are in ContactProperties. A mechanism
/// with these settings is simulated with contact unless the caller names another method of integration.
struct ContactDescription {
  double friction = 0.6;    ///< coefficient of sliding friction of shapes without one of their own
  double margin = 0.01;     ///< gap below which a contact is considered, m
  double threshold = 0.05;  ///< speed of approach below which impacts have no restitution, m/s
  std::vector<std::array<std::string, 2>> ignored = {};  ///< pairs of bodies without contacts
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
  std::vector<Fault> warnings = {};  ///< warnings of the reader that made the description
};

/// Whether a joint has no drive: by default only a free joint of a mechanism with loops or couplings.
inline bool is_passive(const JointDescription& joint, const Description& d) {
  const bool closed = !(d.loops.empty() && d.couplings.empty());
  return joint.passive.value_or(closed && joint.kind == JointKind::free);
}

}  // namespace axode
