#pragma once
#include <functional>
#include <span>
#include <vector>

#include "axode/constraints/prescribed/prescribed_motion.hpp"
#include "axode/drives/added_drive.hpp"
#include "axode/integration/local_coordinates.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/integration/trajectory.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// An event: it occurs when a scalar function of the state changes its sign.
struct Event {
  std::function<double(double t, std::span<const double> q, std::span<const double> v)> value;
  int direction = 0;      ///< +1: only if the value rises, -1: only if it falls
  bool terminal = false;  ///< whether the motion ends at the event
};

/// The coordinates in which a motion is integrated. Trajectories always have the coordinates of the joints.
enum class Coordinates {
  relative,         ///< coordinates of the joints; loops are constraints
  absolute,         ///< poses of bodies in SE(3); joints and loops are constraints
  absolute_SO3xR3,  ///< poses of bodies in SO(3) × R³; joints and loops are constraints
  /// Poses of bodies in SE(3) if a joint on the ground constrains the body, and in SO(3) × R³ otherwise.
  absolute_by_joint,
};

/// Options of a simulation. Couplings with play (backlash) act in simulate(), simulate_fixed() and
/// simulate_stiff(), in relative coordinates: a step ends where a play reaches or leaves one of its ends. If
/// the model has such a coupling, all other simulations throw std::invalid_argument, and these three do so if
/// joint_losses is set and a joint has dry friction or a gear with losses.
struct SimulationOptions {
  Coordinates coordinates = Coordinates::relative;
  /// The local coordinates of a step. Cayley coordinates are allowed in relative coordinates for all methods
  /// except simulate_contact(), and in absolute coordinates for simulate() and simulate_fixed().
  LocalCoordinates local_coordinates = LocalCoordinates::exponential;
  /// A function that writes the drive forces tau (nv numbers) at a time t (s) and state (q, v); they are 0 if
  /// it is empty. The springs of the model act in addition.
  std::function<void(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau)>
      drive = {};
  std::vector<AppliedWrench<>> loads = {};
  /// A function that appends the loads at a time t (s) and state (q, v), such as wind or thrust, to `loads`.
  std::function<void(double t, std::span<const double> q, std::span<const double> v,
                     std::vector<AppliedWrench<>>& loads)>
      computed_loads = {};
  /// Prescribed motions in addition to those of the model. A motion sets the coordinate of a joint, or the
  /// length of a rod (the distance of two points, which a loop joint fixes), as a function of time. Motions
  /// act with all methods, in relative and in absolute coordinates. Steps end where the third, fourth or
  /// fifth derivative of a motion jumps. A motion that cannot be followed ends the trajectory.
  std::vector<PrescribedMotion> motions = {};
  /// Drives with states, in addition to those of the model. Steps end where an input jumps, and with methods
  /// whose steps can be shortened also where the law of a drive changes its form, for example at a limit;
  /// with the others (simulate_symplectic(), simulate_momenta(), simulate_rattle(), simulate_half_explicit(),
  /// and simulate_stiff() in absolute coordinates) a drive changes at the end of the step.
  std::vector<AddedDrive> drives = {};
  /// The states of all drives at the start, in the order of the drives; if empty, chosen by the drives.
  std::vector<double> x = {};
  /// Whether damping, dry friction and gear losses of the joints act. In relative coordinates a joint at rest
  /// sticks while its friction can hold it: a step ends when a joint comes to rest or begins to slide. In
  /// absolute coordinates the dry friction of a joint with the limit f is -f sign(v). If joint_losses is set,
  /// a gear with losses causes std::invalid_argument in absolute coordinates, in simulate_symplectic(),
  /// simulate_momenta() and simulate_contact(), and in models that have a coupling with play.
  bool joint_losses = false;
  std::vector<Event> events = {};
  /// A function that is called with the time t (s) at the end of each step, and during a step with contact
  /// that takes many iterations. If it returns false, the motion ends.
  std::function<bool(double t)> monitor = {};
};

/// Integrates the motion from (q, v) at time 0 until the time `until` (s), in equal steps (the last one may
/// be shorter), with an explicit Runge-Kutta-Munthe-Kaas method on the group of configurations. The method of
/// one stage, Euler's, is semi-implicit: q moves with the new v. If accelerations cannot be computed or are
/// not finite, the trajectory ends early and contains the reason. Throws std::invalid_argument for a wrong
/// size, a quaternion that is not of unit norm, a number that is not finite, until < 0 or step <= 0, and for
/// inconsistent coefficients of the Runge-Kutta method (its Butcher tableau).
Trajectory simulate_fixed(const Model& model, std::span<const double> q, std::span<const double> v,
                          double until, double step, const Tableau& method = runge_kutta(4),
                          const SimulationOptions& options = {});

/// Integrates stiff systems by the generalised-α method on the group of configurations. The method is
/// implicit and of second order, and damps fast oscillations numerically. Its equations are solved by
/// Newton's method with exact derivatives of the dynamics and, if needed, difference quotients of drive
/// forces. The spectral radius at infinity (0 to 1) is the part of a fast oscillation that remains after a
/// step. A step that does not converge ends the motion. Throws std::invalid_argument for a wrong size, a
/// quaternion that is not of unit norm, a number that is not finite, until < 0 or step <= 0, and for a
/// spectral radius outside [0, 1].
///
/// In relative coordinates `stabilized` must be true. In absolute coordinates joints and loops are imposed on
/// positions (index 3) or, if `stabilized` is true, on positions and velocities (index 2, after Gear, Gupta
/// and Leimkuhler); rolling contacts are imposed on velocities. In absolute coordinates, whether stabilised
/// or not, Newton's matrix contains from the forces of springs, dampers and drives only the derivative of
/// each joint force by the coordinate and velocity of the same joint. Stiff springs that connect several
/// joints may then need short steps.
Trajectory simulate_stiff(const Model& model, std::span<const double> q, std::span<const double> v,
                          double until, double step, double spectral_radius = 0.8,
                          const SimulationOptions& options = {}, bool stabilized = true);

/// Integrates in absolute coordinates, which the options must ask for, by RATTLE (order 2) or its
/// compositions (order 4: Suzuki's, order 6: Kahan's and Li's), see (D8.9) of docs/derivations. The implicit
/// method is symplectic if forces have a potential, so that energy errors stay bounded; with damping, drives
/// and rolling contacts it keeps its order only. Joints and loops hold to rounding in positions and
/// velocities. A step that does not converge ends the motion. Throws std::invalid_argument for a wrong size,
/// a quaternion that is not of unit norm, a number that is not finite, until < 0 or step <= 0, other orders,
/// events, elastic stops, relative coordinates and, if joint_losses is set, dry friction.
Trajectory simulate_rattle(const Model& model, std::span<const double> q, std::span<const double> v,
                           double until, double step, int order = 2, const SimulationOptions& options = {});

/// Integrates in absolute coordinates, which the options must ask for, by the half-explicit method of third
/// order (Brasey, Hairer) in the form of Munthe-Kaas. Joints and loops are satisfied to rounding in
/// velocities, and positions are projected onto them at the end of each step. If the pose of a body is
/// integrated in SE(3) (Coordinates::absolute and absolute_by_joint, but not absolute_SO3xR3), a joint
/// between this body and the ground is satisfied to rounding even without the projection. Throws
/// std::invalid_argument for a wrong size, a quaternion that is not of unit norm, a number that is not
/// finite, until < 0 or step <= 0, and for relative coordinates.
Trajectory simulate_half_explicit(const Model& model, std::span<const double> q, std::span<const double> v,
                                  double until, double step, const SimulationOptions& options = {});

/// Integrates configuration and momenta (q, p) by the midpoint rule on the group of configurations (order 2)
/// or its compositions (order 4: Suzuki's, order 6: Kahan's and Li's), see (D8.5) of docs/derivations. The
/// implicit method is symmetric, and symplectic if forces have a potential (and no joint of several
/// velocities has armatures), so that energy errors stay bounded; damping and drives enter by d'Alembert's
/// principle. If only gravity acts on a floating base (a body that a free joint without armature connects to
/// the ground) and its subtree from outside, its linear momentum and its angular momentum about its centre of
/// mass are exact to rounding; without gravity also its spatial momentum. Impulses at both ends of a step
/// close the loops in positions and velocities (D8.7). A step that does not converge ends the motion. Throws
/// std::invalid_argument for a wrong size, a quaternion that is not of unit norm, a number that is not
/// finite, until < 0 or step <= 0, other orders, events, elastic stops, rolling contacts, belts, options that
/// ask for absolute coordinates and, if joint_losses is set, dry friction.
Trajectory simulate_symplectic(const Model& model, std::span<const double> q, std::span<const double> v,
                               double until, double step, int order = 2,
                               const SimulationOptions& options = {});

/// Integrates a motion with contact between the collision shapes of the model and of the ground, and with
/// hard stops. Contact obeys Signorini's condition and Coulomb's law; for each step, Trajectory::certificates
/// has a number that says how exactly. Joints have damping and dry friction if joint_losses is set. Loops are
/// closed at the ends of steps. The step has impulses at both of its ends, with the midpoint rule for the
/// free motion in between (D11.12). It is of second order while no contact begins or ends, and of first order
/// through impacts. Between the impulses, the momenta of a floating base (a body that a free joint without
/// armature connects to the ground) and its subtree are exact to rounding if only gravity acts on them.
/// Throws std::invalid_argument for a wrong size, a quaternion that is not of unit norm, a number that is not
/// finite, until < 0 or step <= 0, options that ask for absolute coordinates, and collision shapes that
/// contact cannot use, such as a mesh without a convex hull.
Trajectory simulate_contact(const Model& model, std::span<const double> q, std::span<const double> v,
                            double until, double step, const SimulationOptions& options = {});

/// Integrates configuration and momenta (q, p) with an explicit Runge-Kutta-Munthe-Kaas method. If only
/// gravity acts on a floating base (a body that a free joint without armature connects to the ground) and its
/// subtree from outside, its linear momentum and its angular momentum about its centre of mass are exact to
/// rounding, but the method is not symplectic. Loops are closed again after each step; rolling contacts are
/// allowed. Throws std::invalid_argument for a wrong size, a quaternion that is not of unit norm, a number
/// that is not finite, until < 0 or step <= 0, events, elastic stops, options that ask for absolute
/// coordinates and, if joint_losses is set, dry friction.
Trajectory simulate_momenta(const Model& model, std::span<const double> q, std::span<const double> v,
                            double until, double step, const Tableau& method = runge_kutta(4),
                            const SimulationOptions& options = {});

struct Tolerances {
  double relative = 1e-8, absolute = 1e-10;
  double first_step = 0;  ///< s; if 0, it is chosen automatically
  /// The longest step, s. If it is 0, the limit is a fiftieth of the whole time in simulate_contact(), and if
  /// SimulationOptions::drive or prescribed motions act, whose short actions could be missed; otherwise there
  /// is none.
  double largest_step = 0;
};
/// Throws std::invalid_argument if a number is negative or not finite, or if both tolerances are 0.
void check_tolerances(const Tolerances& tolerances);

/// Integrates with Dormand's and Prince's method in adaptive steps. The root mean square of all error
/// estimates, each divided by its tolerance, is at most 1 in a step. The tolerances are absolute + relative
/// max(1, |θ|) for the displacement θ of q in the step (rad, m), absolute + relative |v| for velocities, and
/// absolute × nominal + relative |x| for states x of drives with their nominal values. Throws
/// std::invalid_argument for a wrong size, a quaternion that is not of unit norm, a number that is not
/// finite, until < 0, and tolerances that are negative or both 0.
Trajectory simulate(const Model& model, std::span<const double> q, std::span<const double> v, double until,
                    const Tolerances& tolerances = {}, const SimulationOptions& options = {});

/// Integrates a motion with contact in steps that are adapted to tolerances, those of simulate(). Each step
/// is computed as a whole and in two halves, which must agree within the tolerances; the halves are then
/// taken. A step through an impact, or in which a contact or joint begins to stick or to slide, is shortened
/// until the halves agree with the whole step, but not below 1e-9 of the duration of the motion.
Trajectory simulate_contact(const Model& model, std::span<const double> q, std::span<const double> v,
                            double until, const Tolerances& tolerances,
                            const SimulationOptions& options = {});

}  // namespace axode
