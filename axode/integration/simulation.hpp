#pragma once
#include <functional>
#include <span>
#include <vector>

#include "axode/integration/tableau.hpp"
#include "axode/integration/trajectory.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// A scalar function of a state whose zeros are met on the way.
struct Event {
  std::function<double(double t, std::span<const double> q, std::span<const double> v)> value;
  int direction = 0;      ///< +1: only where it rises, -1: only where it falls
  bool terminal = false;  ///< whether the motion ends there
};

/// What a motion is computed in; it is told in those of the joints in any case.
enum class Coordinates {
  relative,         ///< those of the joints; loops are constraints
  absolute,         ///< bodies are points of SE(3), and joints are constraints as well
  absolute_SO3xR3,  ///< bodies are points of SO(3) × R³
};

struct SimulationOptions {
  Coordinates coordinates = Coordinates::relative;
  /// Drive forces: tau (nv) at a time and state. Without it tau is 0. The springs of the model act besides.
  std::function<void(double t, std::span<const double> q, std::span<const double> v, std::span<double> tau)>
      drive = {};
  std::vector<AppliedWrench<>> loads = {};
  /// Loads at a time and state, which it adds to those: wind, thrust, a contact.
  std::function<void(double t, std::span<const double> q, std::span<const double> v,
                     std::vector<AppliedWrench<>>& loads)>
      computed_loads = {};
  /// Damping and dry friction of the joints. In relative coordinates what rests sticks as long as its friction can hold it: steps
  /// end where a joint comes to rest or begins to slide. In absolute ones friction is -f sign(v).
  bool joint_losses = false;
  std::vector<Event> events = {};
  /// Told the time now and then; the motion ends where it returns false.
  std::function<bool(double t)> monitor = {};
};

/// The motion from (q, v) at time 0 until a time, in steps of the same length (the last one shorter), with an explicit method on
/// the group of configurations (Munthe-Kaas; that of one stage, Euler's, is semi-implicit: q moves with the new v). Where accelerations cannot
/// be found or are not finite the trajectory ends, and says so. Throws std::invalid_argument for wrong sizes, a
/// quaternion off 1, numbers that are not finite, until < 0 and step <= 0.
Trajectory simulate_fixed(const Model& model, std::span<const double> q, std::span<const double> v,
                          double until, double step, const Tableau& method = runge_kutta(4),
                          const SimulationOptions& options = {});

/// The same for stiff systems, by generalised-α on the group with Newton's method on exact derivatives of the dynamics:
/// of second order, implicit, with numerical damping of what oscillates quickly. The spectral radius at infinity says how
/// much is left of that in a step, 1 all and 0 nothing. Forces of the drive that depend on the state are differenced where
/// Newton's method needs them. A step that does not converge ends the motion. Throws as simulate_fixed(), and for
/// a radius outside of [0, 1].
///
/// In absolute coordinates joints and loops hold in places (index 3) or, stabilized, in velocities as well (index 2, after Gear,
/// Gupta and Leimkuhler); there Newton's method takes M for the matrix, which stiff springs need short steps for. What rolls
/// does so in velocities in either.
Trajectory simulate_stiff(const Model& model, std::span<const double> q, std::span<const double> v,
                          double until, double step, double spectral_radius = 0.8,
                          const SimulationOptions& options = {}, bool stabilized = true);

/// The same in absolute coordinates, which the options must ask for, by RATTLE (order 2) or its compositions (4: Suzuki's, 6:
/// Kahan's and Li's): symplectic where forces have a potential, so that energy errors stay bounded; joints and loops hold to
/// rounding, in places and in velocities. Damping and drives keep the order. So does what rolls, where it is symmetric and
/// nothing is symplectic. Implicit; a step that does not converge ends the motion. Throws as simulate_fixed(), and for other
/// orders, events, dry friction, stops and relative coordinates.
Trajectory simulate_rattle(const Model& model, std::span<const double> q, std::span<const double> v,
                           double until, double step, int order = 2, const SimulationOptions& options = {});

/// The same in absolute coordinates by the half-explicit method of third order (Brasey, Hairer), as Munthe-Kaas': joints and
/// loops hold to rounding in velocities, and in places on SE(3) for joints whose steps are motions. Throws as simulate_fixed(), and
/// for relative coordinates.
Trajectory simulate_half_explicit(const Model& model, std::span<const double> q, std::span<const double> v,
                                  double until, double step, const SimulationOptions& options = {});

/// The same on (q, p), by the midpoint rule on the group (order 2) or its compositions (4: Suzuki's, 6: Kahan's and Li's): symmetric,
/// symplectic where forces have a potential, so that energy errors stay bounded; damping and drives enter by d'Alembert's
/// principle. What floats is seen from its centre of mass, whose motion is exact, and its momentum is a state of its own: Π^s,
/// under gravity L_c and P, are exact to rounding. Loops are closed by impulses at both ends of a step, in places and
/// velocities. Implicit; a step that does not converge ends the motion. Throws as simulate_fixed(), for events, dry friction,
/// what rolls, which has nothing symplectic, and other orders. (Armatures of joints with several velocities, which have momenta
/// that do not turn with the joint, are forces here: order and momenta stay, symplecticity does not.)
Trajectory simulate_symplectic(const Model& model, std::span<const double> q, std::span<const double> v,
                               double until, double step, int order = 2,
                               const SimulationOptions& options = {});

/// The same, with momenta exact likewise, by an explicit method on the group of (q, p) (Munthe-Kaas), which is not symplectic.
/// Loops are closed again after each step; it takes what rolls.
Trajectory simulate_momenta(const Model& model, std::span<const double> q, std::span<const double> v,
                            double until, double step, const Tableau& method = runge_kutta(4),
                            const SimulationOptions& options = {});

struct Tolerances {
  double relative = 1e-8, absolute = 1e-10;
  double first_step = 0, largest_step = 0;  ///< 0: chosen, and unlimited
};
/// The same with a method that estimates its error, in steps as long as the error of q and v allows: in the algebra,
/// where it is at most absolute + relative max(1, |θ|) in rad and m, and absolute + relative |v|, as root mean square.
Trajectory simulate(const Model& model, std::span<const double> q, std::span<const double> v, double until,
                    const Tolerances& tolerances = {}, const SimulationOptions& options = {});

}  // namespace axode
