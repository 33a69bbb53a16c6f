#pragma once
#include <optional>
#include <utility>

#include "axode/table/words.hpp"

/// The table of functions of a state. From its rows C++, the command, Python and the tests read the
/// arguments, results and costs of each function, and which parts of a mechanism it counts. The kernels are
/// called in axode/catalog/functions.cpp.
namespace axode::catalog {
namespace table {

using enum Input;
using enum Entry;
using enum Extent;
using enum Choice;
using enum Cost;
using enum Memory;

inline constexpr std::string_view screws = "rad/s, m/s", rates = "rad/s^2, m/s^2", wrenches = "N m, N",
                                  impulses = "N m s, N s", forces = "N m for angles, N for lengths",
                                  inertias = "kg m^2, kg m, kg";

/// The properties that families of rows count. Springs, dampers and stops act in simulations only; damping
/// and friction act as well if a caller enables them.
inline constexpr std::string_view add_springs = "spring_forces(q, v) are to be added to tau",
                                  subtract_springs = "spring_forces(q, v) are to be subtracted from tau";
/// A prescribed motion is a force on its joint or along its rod. Functions for a given motion of the
/// mechanism ignore it; accelerations, and what follows from them, depend on the time if there are such
/// motions.
inline constexpr Count at_a_time =
    refused("simulate and forward_dynamics_at count them, because they know the time");
/// Drives with states act by forces, which are given as tau.
inline constexpr Count forces_of_drives = of_the_tree("tau has their forces, which DriveSystem computes");
/// Whether a coupling with play is at one of its ends is no part of a state.
inline constexpr Count free_plays = of_the_tree("simulate counts them");
/// Contacts of collision shapes and hard stops act by impulses over a step, which a function of a state does
/// not have.
inline constexpr Count without_contacts =
    of_the_tree("simulate with contact and ContactDynamics count contacts and hard stops");
/// Damping and dry friction of joints, which a caller enables, without the losses of gears: these depend on
/// the force that a gear transmits.
inline constexpr Count without_gears{
    Word::partly, "losses of gears are refused; inverse_dynamics, forward_dynamics and simulate count them"};
/// The same treatment of all properties but joint losses.
consteval Counts with_losses(Counts counts, Count joint_losses) {
  counts.joint_losses = joint_losses;
  return counts;
}
inline constexpr Counts of_motion{.loops = of_the_tree(),
                                  .passive_joints = of_the_tree(),
                                  .springs = of_the_tree(),
                                  .joint_losses = of_the_tree(),
                                  .motions = of_the_tree(),
                                  .drives = of_the_tree(),
                                  .plays = of_the_tree(),
                                  .contacts = of_the_tree()};
inline constexpr Counts of_loads{.loops = of_the_tree(),
                                 .passive_joints = of_the_tree(),
                                 .springs = of_the_tree(),
                                 .joint_losses = without_gears,
                                 .motions = of_the_tree(),
                                 .drives = of_the_tree(),
                                 .plays = of_the_tree(),
                                 .contacts = of_the_tree()};
inline constexpr Counts of_columns{
    .loops = of_the_tree("loops allow only velocities v with loop_jacobian(q) v = 0"),
    .passive_joints = of_the_tree(),
    .springs = of_the_tree(),
    .joint_losses = of_the_tree(),
    .motions = of_the_tree(),
    .drives = of_the_tree(),
    .plays = of_the_tree(),
    .contacts = of_the_tree()};
inline constexpr Counts of_terms{
    .loops = of_the_tree(
        "independent_equations has the terms that belong to independent velocities of closed loops"),
    .passive_joints = of_the_tree(),
    .springs = of_the_tree(),
    .joint_losses = of_the_tree(),
    .motions = of_the_tree(),
    .drives = of_the_tree(),
    .plays = of_the_tree(),
    .contacts = of_the_tree()};
inline constexpr Counts of_gravity{
    .loops = of_the_tree(
        "inverse_dynamics with v = a = 0 gives the drive forces that hold a mechanism with loops"),
    .passive_joints = of_the_tree(),
    .springs = of_the_tree(),
    .joint_losses = of_the_tree(),
    .motions = of_the_tree(),
    .drives = of_the_tree(),
    .plays = of_the_tree(),
    .contacts = of_the_tree()};
inline constexpr Counts of_springs{.loops = of_the_tree(),
                                   .passive_joints = of_the_tree(),
                                   .springs = counted,
                                   .joint_losses = of_the_tree(),
                                   .motions = of_the_tree(),
                                   .drives = of_the_tree(),
                                   .plays = of_the_tree(),
                                   .contacts = of_the_tree()};
inline constexpr Counts of_forces{
    .loops = counted,
    .passive_joints = {Word::optional, "a LoopWorkspace, or drives in Python, leaves them without forces"},
    .springs = of_the_tree(subtract_springs),
    .joint_losses = optional,
    .motions = of_the_tree("tau has the forces that they take"),
    .drives = forces_of_drives,
    .plays = free_plays,
    .contacts = without_contacts};
inline constexpr Counts of_wrenches{.loops = counted,
                                    .passive_joints = of_the_tree(),
                                    .springs = of_the_tree(),
                                    .joint_losses = optional,
                                    .motions = of_the_tree(),
                                    .drives = of_the_tree(),
                                    .plays = of_the_tree(),
                                    .contacts = of_the_tree()};
inline constexpr Counts of_accelerations{.loops = counted,
                                         .passive_joints = of_the_tree(),
                                         .springs = of_the_tree(add_springs),
                                         .joint_losses = optional,
                                         .motions = at_a_time,
                                         .drives = forces_of_drives,
                                         .plays = free_plays,
                                         .contacts = without_contacts};
inline constexpr Counts of_variations_of_accelerations = with_losses(of_accelerations, without_gears);
inline constexpr Counts of_impulses{.loops = counted,
                                    .passive_joints = of_the_tree(),
                                    .springs = of_the_tree(),
                                    .joint_losses = of_the_tree(),
                                    .motions = refused("reduced locks the joints that they move"),
                                    .drives = of_the_tree(),
                                    .plays = of_the_tree(),
                                    .contacts = of_the_tree()};
inline constexpr Counts of_momentum_form{
    .loops = refused("forward_dynamics counts them; momenta(q, v) of its motion are those of the mechanism"),
    .passive_joints = of_the_tree(),
    .springs = of_the_tree(add_springs),
    .joint_losses = without_gears,
    .motions = at_a_time,
    .drives = forces_of_drives,
    .plays = free_plays,
    .contacts = of_the_tree()};
inline constexpr Counts of_derivatives_of_forces{
    .loops = refused("forward_dynamics_derivatives and independent_linearization count them"),
    .passive_joints = of_the_tree(),
    .springs = of_the_tree("spring_force_derivatives(q, v) are to be subtracted"),
    .joint_losses = without_gears,
    .motions = of_the_tree(),
    .drives = forces_of_drives,
    .plays = free_plays,
    .contacts = of_the_tree()};
inline constexpr Counts of_derivatives_of_accelerations{
    .loops =
        refused("forward_dynamics_derivatives, forward_dynamics_jvp and forward_dynamics_vjp count them"),
    .passive_joints = of_the_tree(),
    .springs = of_the_tree(add_springs),
    .joint_losses = without_gears,
    .motions = at_a_time,
    .drives = forces_of_drives,
    .plays = free_plays,
    .contacts = without_contacts};

}  // namespace table

/// All functions, in the order of the documentation.
inline constexpr auto functions_of_state = [] {
  using namespace table;
  return std::to_array<Words>({
      // clang-format off
      {.name = "poses", .purpose = "poses of all frames in the inertial frame", .units = "m", .takes = {q},
       .choice = none, .entry = pose, .shape = {n_frames}, .columns = false, .symbols = {"C"},
       .together = "C", .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .lanes = true, .tape = true, .counts = of_motion},
      {.name = "pose", .purpose = "pose of a frame in the inertial frame", .units = "m", .takes = {q, place},
       .choice = none, .entry = pose, .shape = {}, .columns = false, .symbols = {"C"}, .together = "C",
       .cost = linear, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
       .tape = true, .counts = of_motion},
      {.name = "twists", .purpose = "twists of all frames", .units = screws, .takes = {q, v},
       .choice = representation, .entry = twist, .shape = {n_frames}, .columns = false, .symbols = {"V"},
       .cost = linear, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
       .tape = false, .counts = of_motion},
      {.name = "accelerations",
       .purpose = "time derivatives of the components of the twists of all frames, without gravity",
       .units = rates, .takes = {q, v, a}, .choice = representation, .entry = rate, .shape = {n_frames},
       .columns = false, .symbols = {"V'"}, .cost = linear, .allocates = false, .memory = may_share,
       .may_fail = false, .lanes = false, .tape = false, .counts = of_motion},
      {.name = "jacobian", .purpose = "Jacobian J of a frame, with V = J v: a column for each velocity",
       .units = "rad/s, m/s per unit of the velocity", .takes = {q, place}, .choice = representation,
       .entry = twist, .shape = {nv}, .columns = true, .symbols = {"J"}, .together = "J", .cost = linear,
       .allocates = false, .memory = own, .may_fail = false, .lanes = false, .tape = true,
       .counts = of_columns},
      {.name = "jacobians", .purpose = "Jacobians of all frames",
       .units = "rad/s, m/s per unit of the velocity", .takes = {q}, .choice = representation,
       .entry = twist, .shape = {n_frames, nv}, .columns = true, .symbols = {"J"}, .cost = quadratic,
       .allocates = false, .memory = own, .may_fail = false, .lanes = false, .tape = false,
       .counts = of_columns},
      {.name = "jacobian_rate", .purpose = "time derivative of the Jacobian of a frame",
       .units = "rad/s^2, m/s^2 per unit of the velocity", .takes = {q, v, place}, .choice = representation,
       .entry = rate, .shape = {nv}, .columns = true, .symbols = {"J'"}, .cost = linear, .allocates = true,
       .memory = own, .may_fail = false, .lanes = false, .tape = false, .counts = of_columns},
      {.name = "relative_jacobian",
       .purpose = "Jacobian of a frame for the motion that an observer in another frame sees",
       .units = "rad/s, m/s per unit of the velocity", .takes = {q, place, base}, .choice = representation,
       .entry = twist, .shape = {nv}, .columns = true, .symbols = {"J"}, .cost = linear, .allocates = false,
       .memory = own, .may_fail = false, .lanes = false, .tape = false, .counts = of_columns},
      {.name = "joint_screws",
       .purpose = "instantaneous joint screws in inertial axes about the inertial origin",
       .units = "rad/s, m/s per unit of the velocity", .takes = {q}, .choice = none, .entry = twist,
       .shape = {n_screws}, .columns = true, .symbols = {"J"}, .together = "J", .cost = linear,
       .allocates = false, .memory = own, .may_fail = false, .lanes = true, .tape = false,
       .counts = of_columns},
      {.name = "center_of_mass", .purpose = "centre of mass of all moving bodies, in the inertial frame",
       .units = "m", .takes = {q}, .choice = none, .entry = vector, .shape = {}, .columns = false,
       .symbols = {"c"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .lanes = false, .tape = false, .counts = of_motion},
      {.name = "center_of_mass_jacobian",
       .purpose = "velocity of the centre of mass for a unit of each velocity, in inertial axes",
       .units = "m/s per unit of the velocity", .takes = {q}, .choice = none, .entry = vector, .shape = {nv},
       .columns = true, .symbols = {"J"}, .cost = linear, .allocates = false, .memory = may_share,
       .may_fail = false, .lanes = false, .tape = false, .counts = of_motion},
      {.name = "centroidal_momentum_matrix",
       .purpose = "momentum about the centre of mass for a unit of each velocity, in inertial axes",
       .units = inertias, .takes = {q}, .choice = none, .entry = momentum, .shape = {nv}, .columns = true,
       .symbols = {"A"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .lanes = false, .tape = false, .counts = of_motion},
      {.name = "centroidal_momentum_matrix_rate",
       .purpose = "time derivative of the centroidal momentum matrix", .units = "kg m^2/s, kg m/s, kg/s",
       .takes = {q, v}, .choice = none, .entry = wrench, .shape = {nv}, .columns = true, .symbols = {"A'"},
       .cost = linear, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
       .tape = false, .counts = of_motion},
      {.name = "inverse_dynamics", .purpose = "drive forces tau that make the accelerations a",
       .units = forces, .takes = {q, v, a, loads}, .choice = recursion, .entry = number, .shape = {nv},
       .columns = false, .symbols = {"tau"}, .together = "tau", .cost = linear, .allocates = false,
       .memory = may_share, .may_fail = false, .lanes = true, .tape = true, .counts = of_forces},
      {.name = "forward_dynamics", .purpose = "accelerations that the drive forces tau make", .units = rates,
       .takes = {q, v, tau, loads}, .choice = recursion, .entry = number, .shape = {nv}, .columns = false,
       .symbols = {"a"}, .together = "a", .cost = linear, .allocates = false, .memory = may_share,
       .may_fail = true, .lanes = true, .tape = true, .counts = of_accelerations},
      {.name = "joint_wrenches",
       .purpose = "wrenches that the joints transmit to their bodies, from drives and constraints together",
       .units = wrenches, .takes = {q, v, a, loads, at}, .choice = representation, .entry = wrench,
       .shape = {n_joints}, .columns = false, .symbols = {"W"}, .cost = linear, .allocates = false,
       .memory = may_share, .may_fail = false, .lanes = false, .tape = false, .counts = of_wrenches},
      {.name = "mass_matrix", .purpose = "mass matrix M(q), armatures included", .units = inertias,
       .takes = {q}, .choice = recursion, .entry = number, .shape = {nv, nv}, .columns = false,
       .symbols = {"M"}, .together = "M", .cost = quadratic, .allocates = false, .memory = may_share,
       .may_fail = false, .lanes = true, .tape = true, .counts = of_terms},
      {.name = "inverse_mass_matrix", .purpose = "inverse of the mass matrix",
       .units = "1/(kg m^2), 1/(kg m), 1/kg", .takes = {q}, .choice = recursion, .entry = number,
       .shape = {nv, nv}, .columns = false, .symbols = {"M^-1"}, .together = "M_inverse", .cost = quadratic,
       .allocates = false, .memory = may_share, .may_fail = true, .lanes = true, .tape = true,
       .counts = of_terms},
      {.name = "mass_matrix_partials",
       .purpose = "partial derivatives of the mass matrix, a matrix for each direction of the configuration",
       .units = "kg m^2, kg m, kg, kg/m", .takes = {q}, .choice = none, .entry = number,
       .shape = {nv, nv, nv}, .columns = false, .symbols = {"dM"}, .cost = cubic, .allocates = false,
       .memory = may_share, .may_fail = false, .derivative_of = "mass_matrix", .lanes = false, .tape = false,
       .counts = of_terms},
      {.name = "inverse_mass_matrix_partials",
       .purpose = "partial derivatives of the inverse of the mass matrix, a matrix for each direction of "
                  "the configuration",
       .units = "1/(kg m^2), 1/(kg m), 1/kg per unit of the direction", .takes = {q}, .choice = none,
       .entry = number, .shape = {nv, nv, nv}, .columns = false, .symbols = {"dM^-1"}, .cost = cubic,
       .allocates = true, .memory = own, .may_fail = true, .derivative_of = "inverse_mass_matrix",
       .lanes = false, .tape = false, .counts = of_terms},
      {.name = "coriolis_matrix", .purpose = "Coriolis matrix C(q, v), in the form that the caller chooses",
       .units = "kg m^2/s, kg m/s, kg/s", .takes = {q, v, form}, .choice = none, .entry = number,
       .shape = {nv, nv}, .columns = false, .symbols = {"C"}, .cost = quadratic, .allocates = false,
       .memory = may_share, .may_fail = false, .lanes = false, .tape = false, .counts = of_terms},
      {.name = "coriolis_vector", .purpose = "Coriolis and centrifugal forces C(q, v) v", .units = forces,
       .takes = {q, v}, .choice = recursion, .entry = number, .shape = {nv}, .columns = false,
       .symbols = {"C v"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .lanes = false, .tape = false, .counts = of_terms},
      {.name = "gravity_torques",
       .purpose = "generalised forces g(q) that hold the tree at rest against gravity", .units = forces,
       .takes = {q}, .choice = recursion, .entry = number, .shape = {nv}, .columns = false, .symbols = {"g"},
       .cost = linear, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
       .tape = false, .counts = of_gravity},
      {.name = "generalized_loads", .purpose = "generalised forces of the loads", .units = forces,
       .takes = {q, v, loads}, .choice = recursion, .entry = number, .shape = {nv}, .columns = false,
       .symbols = {"Q"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .lanes = false, .tape = false, .counts = of_loads},
      {.name = "christoffel",
       .purpose = "Christoffel symbols of the first kind, Gamma_ijk, a matrix over (j, k) for each i",
       .units = "kg m^2, kg m, kg, kg/m", .takes = {q}, .choice = none, .entry = number,
       .shape = {nv, nv, nv}, .columns = false, .symbols = {"Gamma"}, .cost = cubic, .allocates = false,
       .memory = may_share, .may_fail = false, .lanes = false, .tape = false, .counts = of_terms},
      {.name = "kinetic_energy", .purpose = "kinetic energy of bodies and armatures", .units = "J",
       .takes = {q, v}, .choice = none, .entry = number, .shape = {}, .columns = false, .symbols = {"T"},
       .cost = linear, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
       .tape = false, .counts = of_motion},
      {.name = "potential_energy", .purpose = "potential energy of gravity, 0 at the inertial origin",
       .units = "J", .takes = {q}, .choice = none, .entry = number, .shape = {}, .columns = false,
       .symbols = {"U"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .lanes = false, .tape = false, .counts = of_motion},
      {.name = "spring_forces",
       .purpose = "generalised forces of springs, dampers and stops, which act in simulations",
       .units = forces, .takes = {q, v}, .choice = none, .entry = number, .shape = {nv}, .columns = false,
       .symbols = {"tau"}, .cost = linear, .allocates = false, .memory = own, .may_fail = false,
       .lanes = false, .tape = false, .counts = of_springs},
      {.name = "elastic_energy", .purpose = "energy of springs and stops", .units = "J", .takes = {q},
       .choice = none, .entry = number, .shape = {}, .columns = false, .symbols = {"U"}, .cost = linear,
       .allocates = false, .memory = may_share, .may_fail = false, .lanes = false, .tape = false,
       .counts = of_springs},
      {.name = "load_powers", .purpose = "power of each load", .units = "W", .takes = {q, v, loads},
       .choice = none, .entry = number, .shape = {n_loads}, .columns = false, .symbols = {"power"},
       .cost = linear, .allocates = false, .memory = own, .may_fail = false, .lanes = false, .tape = false,
       .counts = of_motion},
      {.name = "centroidal_inertia",
       .purpose = "mass of the whole mechanism, and its rotational inertia about its centre of mass in "
                  "inertial axes",
       .units = "kg, kg m, kg m^2", .takes = {q}, .choice = none, .entry = inertia, .shape = {},
       .columns = false, .symbols = {"M"}, .cost = linear, .allocates = false, .memory = may_share,
       .may_fail = false, .lanes = false, .tape = false, .counts = of_motion},
      {.name = "impulse_response",
       .purpose = "M^-1 J^T, a column for each velocity: its jump for a unit of impulse on the frame",
       .units = "rad/s, m/s per N m s, N s", .takes = {q, place}, .choice = representation, .entry = twist,
       .shape = {nv}, .columns = true, .symbols = {"Y"}, .cost = linear, .allocates = false,
       .memory = own, .may_fail = true, .lanes = false, .tape = false, .counts = of_impulses},
      {.name = "inverse_operational_space_inertia",
       .purpose = "J M^-1 J^T: the twist that a frame gets from an impulse",
       .units = "rad/s, m/s per N m s, N s", .takes = {q, place}, .choice = representation, .entry = twist,
       .shape = {six}, .columns = true, .symbols = {"J M^-1 J^T"}, .cost = linear, .allocates = false,
       .memory = may_share, .may_fail = true, .lanes = false, .tape = false, .counts = of_impulses},
      {.name = "operational_space_inertia",
       .purpose = "(J M^-1 J^T)^-1: the inertia that a frame shows to a wrench; there is none where the "
                  "frame cannot move in all directions",
       .units = inertias, .takes = {q, place}, .choice = representation, .entry = momentum, .shape = {six},
       .columns = true, .symbols = {"Lambda"}, .cost = linear, .allocates = false, .memory = may_share,
       .may_fail = true, .lanes = false, .tape = false, .counts = of_impulses},
      {.name = "regressor",
       .purpose = "regressor Y of inverse dynamics, Y pi = M a + C v + g, with ten inertial parameters pi "
                  "for each body",
       .units = "N m, N per unit of the parameter", .takes = {q, v, a}, .choice = none, .entry = number,
       .shape = {nv, n_parameters}, .columns = false, .symbols = {"Y"}, .cost = quadratic,
       .allocates = false, .memory = may_share, .may_fail = false, .lanes = false, .tape = false,
       .counts = of_terms},
      {.name = "kinetic_energy_regressor",
       .purpose = "regressor y of the kinetic energy of the bodies, T = y pi",
       .units = "J per unit of the parameter", .takes = {q, v}, .choice = none, .entry = number,
       .shape = {n_parameters}, .columns = false, .symbols = {"y"}, .cost = linear, .allocates = false,
       .memory = may_share, .may_fail = false, .lanes = false, .tape = false, .counts = of_motion},
      {.name = "potential_energy_regressor", .purpose = "regressor y of the potential energy, U = y pi",
       .units = "J per unit of the parameter", .takes = {q}, .choice = none, .entry = number,
       .shape = {n_parameters}, .columns = false, .symbols = {"y"}, .cost = linear, .allocates = false,
       .memory = may_share, .may_fail = false, .lanes = false, .tape = false, .counts = of_motion},
      {.name = "momenta", .purpose = "generalised momenta p = M v", .units = impulses, .takes = {q, v},
       .choice = none, .entry = number, .shape = {nv}, .columns = false, .symbols = {"p"}, .cost = linear,
       .allocates = false, .memory = may_share, .may_fail = false, .lanes = false, .tape = false,
       .counts = of_motion},
      {.name = "from_momenta", .purpose = "velocities v = M^-1 p", .units = screws, .takes = {q, p},
       .choice = none, .entry = number, .shape = {nv}, .columns = false, .symbols = {"v"}, .cost = linear,
       .allocates = false, .memory = may_share, .may_fail = true, .lanes = false, .tape = false,
       .counts = of_terms},
      {.name = "momentum_form", .purpose = "rates of the state (q, p) under the drive forces tau",
       .units = "rad/s, m/s; N m, N", .takes = {q, p, tau, loads}, .choice = none, .entry = number,
       .shape = {nv}, .columns = false, .symbols = {"v", "dp"}, .cost = linear, .allocates = false,
       .memory = may_share, .may_fail = true, .lanes = false, .tape = false, .counts = of_momentum_form},
      {.name = "body_momenta", .purpose = "momenta of all bodies in their frames", .units = impulses,
       .takes = {q, v}, .choice = representation, .entry = momentum, .shape = {n_bodies}, .columns = false,
       .symbols = {"Pi"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .lanes = false, .tape = false, .counts = of_motion},
      {.name = "spatial_momentum", .purpose = "momentum of the whole mechanism about the inertial origin",
       .units = impulses, .takes = {q, v}, .choice = none, .entry = momentum, .shape = {}, .columns = false,
       .symbols = {"Pi"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .lanes = false, .tape = false, .counts = of_motion},
      {.name = "centroidal_momentum",
       .purpose = "momentum of the whole mechanism about its centre of mass, in inertial axes",
       .units = impulses, .takes = {q, v}, .choice = none, .entry = momentum, .shape = {}, .columns = false,
       .symbols = {"Pi"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .lanes = false, .tape = false, .counts = of_motion},
      {.name = "inverse_dynamics_derivatives", .purpose = "partial derivatives of inverse dynamics",
       .units = "of tau per unit of the direction", .takes = {q, v, a, loads}, .choice = none,
       .entry = number, .shape = {nv, nv}, .columns = false, .symbols = {"dtau/dq", "dtau/dv", "dtau/da"},
       .together = "dtau", .cost = quadratic, .allocates = false, .memory = may_share, .may_fail = false,
       .derivative_of = "inverse_dynamics", .lanes = true, .tape = true, .counts = of_derivatives_of_forces},
      {.name = "forward_dynamics_derivatives", .purpose = "partial derivatives of forward dynamics",
       .units = "of a per unit of the direction", .takes = {q, v, tau, loads}, .choice = none,
       .entry = number, .shape = {nv, nv}, .columns = false, .symbols = {"da/dq", "da/dv", "da/dtau"},
       .together = "da", .cost = quadratic, .allocates = false, .memory = may_share, .may_fail = true,
       .derivative_of = "forward_dynamics", .lanes = true, .tape = true, .counts = of_variations_of_accelerations},
      {.name = "momentum_form_derivatives", .purpose = "partial derivatives of momentum_form",
       .units = "of v and p' per unit of the direction", .takes = {q, p, loads}, .choice = none,
       .entry = number, .shape = {nv, nv}, .columns = false,
       .symbols = {"dv/dq", "dv/dp", "dp'/dq", "dp'/dp"}, .cost = quadratic, .allocates = false,
       .memory = own, .may_fail = true, .derivative_of = "momentum_form", .lanes = false, .tape = false,
       .counts = of_momentum_form},
      {.name = "gravity_derivatives", .purpose = "partial derivatives of gravity_torques",
       .units = "of g per unit of the direction", .takes = {q}, .choice = none, .entry = number,
       .shape = {nv, nv}, .columns = false, .symbols = {"dg/dq"}, .cost = quadratic, .allocates = false,
       .memory = may_share, .may_fail = false, .derivative_of = "gravity_torques", .lanes = false,
       .tape = false, .counts = of_gravity},
      {.name = "coriolis_derivatives", .purpose = "partial derivatives of coriolis_vector",
       .units = "of tau per unit of the direction", .takes = {q, v}, .choice = none, .entry = number,
       .shape = {nv, nv}, .columns = false, .symbols = {"d(C v)/dq", "d(C v)/dv"}, .cost = quadratic,
       .allocates = false, .memory = may_share, .may_fail = false, .derivative_of = "coriolis_vector",
       .lanes = false, .tape = false, .counts = of_terms},
      {.name = "generalized_load_derivatives", .purpose = "partial derivatives of generalized_loads",
       .units = "of tau per unit of the direction", .takes = {q, v, loads}, .choice = none, .entry = number,
       .shape = {nv, nv}, .columns = false, .symbols = {"dQ/dq", "dQ/dv"}, .cost = quadratic,
       .allocates = false, .memory = may_share, .may_fail = false, .derivative_of = "generalized_loads",
       .lanes = false, .tape = false, .counts = of_loads},
      {.name = "spring_force_derivatives", .purpose = "partial derivatives of spring_forces",
       .units = "of tau per unit of the direction", .takes = {q, v}, .choice = none, .entry = number,
       .shape = {nv, nv}, .columns = false, .symbols = {"dtau/dq", "dtau/dv"}, .cost = quadratic,
       .allocates = false, .memory = own, .may_fail = false, .derivative_of = "spring_forces",
       .lanes = false, .tape = false, .counts = of_springs},
      {.name = "kinetic_energy_gradient",
       .purpose = "gradients of the kinetic energy by configuration and velocities",
       .units = "J per unit of the direction", .takes = {q, v}, .choice = none, .entry = number,
       .shape = {nv}, .columns = false, .symbols = {"dT/dq", "dT/dv"}, .cost = linear, .allocates = false,
       .memory = may_share, .may_fail = false, .derivative_of = "kinetic_energy", .lanes = false,
       .tape = false, .counts = of_motion},
      {.name = "motion_derivatives",
       .purpose = "partial derivatives of the twist of a frame and of its rate, a column for each direction",
       .units = "of V and V' per unit of the direction", .takes = {q, v, a, place}, .choice = representation,
       .entry = twist, .shape = {nv}, .columns = true, .symbols = {"dV/dq", "dV/dv", "dV'/dq", "dV'/dv"},
       .cost = linear, .allocates = false, .memory = own, .may_fail = false, .lanes = false, .tape = false,
       .counts = of_motion},
      {.name = "motion_jvp",
       .purpose = "derivatives of pose (as a body-fixed displacement), twist and its rate along a direction",
       .units = "of X, V and V' along the direction", .takes = {q, v, a, place, dq, dv, da},
       .choice = representation, .entry = twist, .shape = {}, .columns = false,
       .symbols = {"dX", "dV", "dV'"}, .cost = linear, .allocates = false, .memory = may_share,
       .may_fail = false, .lanes = false, .tape = false, .counts = of_motion},
      {.name = "inverse_dynamics_geometry_derivatives",
       .purpose = "partial derivatives of the drive forces by displacements of the joints",
       .units = "of tau per rad, m", .takes = {q, v, a, loads}, .choice = none, .entry = number,
       .shape = {nv, n_bodies, six}, .columns = false, .symbols = {"dtau/dpi"}, .cost = quadratic,
       .allocates = false, .memory = own, .may_fail = false, .derivative_of = "inverse_dynamics",
       .lanes = false, .tape = false, .counts = of_derivatives_of_forces},
      {.name = "forward_dynamics_geometry_derivatives",
       .purpose = "partial derivatives of the accelerations by displacements of the joints",
       .units = "of a per rad, m", .takes = {q, v, tau, loads}, .choice = none, .entry = number,
       .shape = {nv, n_bodies, six}, .columns = false, .symbols = {"da/dpi"}, .cost = quadratic,
       .allocates = false, .memory = own, .may_fail = true, .derivative_of = "forward_dynamics",
       .lanes = false, .tape = false, .counts = of_derivatives_of_accelerations},
      {.name = "inverse_dynamics_geometry_vjp",
       .purpose = "gradient of the drive forces weighted with w, by displacements of the joints",
       .units = "of w tau per rad, m", .takes = {q, v, a, weights, loads}, .choice = none, .entry = number,
       .shape = {n_bodies, six}, .columns = false, .symbols = {"by pi"}, .cost = linear, .allocates = false,
       .memory = own, .may_fail = false, .derivative_of = "inverse_dynamics", .lanes = false, .tape = false,
       .counts = of_derivatives_of_forces},
      {.name = "forward_dynamics_geometry_vjp",
       .purpose = "gradient of the accelerations weighted with w, by displacements of the joints",
       .units = "of w a per rad, m", .takes = {q, v, tau, weights, loads}, .choice = none, .entry = number,
       .shape = {n_bodies, six}, .columns = false, .symbols = {"by pi"}, .cost = linear, .allocates = false,
       .memory = own, .may_fail = true, .derivative_of = "forward_dynamics", .lanes = false, .tape = false,
       .counts = of_derivatives_of_accelerations},
      {.name = "frame_geometry_jacobian",
       .purpose = "body-fixed twist of a frame for a unit of displacement of each joint",
       .units = "rad, m per rad, m", .takes = {q, place}, .choice = none, .entry = number,
       .shape = {six, n_bodies, six}, .columns = false, .symbols = {"J"}, .cost = linear, .allocates = false,
       .memory = own, .may_fail = false, .lanes = false, .tape = false, .counts = of_motion},
      {.name = "jacobian_geometry_derivatives",
       .purpose = "derivatives of the body-fixed Jacobian of a frame by displacements of the joints",
       .units = "of J per rad, m", .takes = {q, place}, .choice = none, .entry = twist,
       .shape = {n_bodies, six, nv}, .columns = true, .symbols = {"dJ/dpi"}, .cost = quadratic,
       .allocates = false, .memory = own, .may_fail = false, .derivative_of = "jacobian", .lanes = false,
       .tape = false, .counts = of_motion},
      {.name = "inverse_dynamics_jvp",
       .purpose = "derivative of the drive forces along a direction (dq, dv, da)", .units = forces,
       .takes = {q, v, a, dq, dv, da, loads}, .choice = none, .entry = number, .shape = {nv},
       .columns = false, .symbols = {"dtau"}, .together = "dtau", .cost = linear, .allocates = false,
       .memory = may_share, .may_fail = false, .derivative_of = "inverse_dynamics", .lanes = true,
       .tape = true, .counts = of_derivatives_of_forces},
      {.name = "inverse_dynamics_vjp", .purpose = "gradient of the drive forces weighted with w",
       .units = "of w tau per unit of the direction", .takes = {q, v, a, weights, loads}, .choice = none,
       .entry = number, .shape = {nv}, .columns = false, .symbols = {"by q", "by v", "by a"},
       .together = "gradient", .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
       .derivative_of = "inverse_dynamics", .lanes = true, .tape = true, .counts = of_derivatives_of_forces},
      {.name = "forward_dynamics_jvp",
       .purpose = "derivative of the accelerations along a direction (dq, dv, dtau)", .units = rates,
       .takes = {q, v, tau, dq, dv, dtau, loads}, .choice = none, .entry = number, .shape = {nv},
       .columns = false, .symbols = {"da"}, .together = "da", .cost = linear, .allocates = false,
       .memory = may_share, .may_fail = true, .derivative_of = "forward_dynamics", .lanes = true,
       .tape = true, .counts = of_variations_of_accelerations},
      {.name = "forward_dynamics_vjp", .purpose = "gradient of the accelerations weighted with w",
       .units = "of w a per unit of the direction", .takes = {q, v, tau, weights, loads}, .choice = none,
       .entry = number, .shape = {nv}, .columns = false, .symbols = {"by q", "by v", "by tau"},
       .together = "gradient", .cost = linear, .allocates = false, .memory = may_share, .may_fail = true,
       .derivative_of = "forward_dynamics", .lanes = true, .tape = true, .counts = of_variations_of_accelerations},
      {.name = "inverse_dynamics_hessian",
       .purpose = "second partial derivatives of the drive forces weighted with w",
       .units = "of w tau per units of the directions", .takes = {q, v, a, weights, loads}, .choice = none,
       .entry = number, .shape = {nv, nv}, .columns = false,
       .symbols = {"by q, q", "by q, v", "by v, v", "by a, q"}, .together = "hessian", .cost = quadratic,
       .allocates = false, .memory = may_share, .may_fail = false, .derivative_of = "inverse_dynamics",
       .lanes = false, .tape = true, .counts = of_derivatives_of_forces},
      {.name = "forward_dynamics_hessian",
       .purpose = "second partial derivatives of the accelerations weighted with w",
       .units = "of w a per units of the directions", .takes = {q, v, tau, weights, loads}, .choice = none,
       .entry = number, .shape = {nv, nv}, .columns = false,
       .symbols = {"by q, q", "by q, v", "by v, v", "by tau, q"}, .together = "hessian", .cost = cubic,
       .allocates = false, .memory = may_share, .may_fail = true, .derivative_of = "forward_dynamics",
       .lanes = false, .tape = true, .counts = of_derivatives_of_accelerations},
      {.name = "inverse_dynamics_second_derivatives",
       .purpose = "second partial derivatives of the drive forces, without loads",
       .units = "of tau per units of the directions", .takes = {q, v, a}, .choice = none, .entry = number,
       .shape = {nv, nv, nv}, .columns = false, .symbols = {"by q, q", "by q, v", "by v, v", "by a, q"},
       .cost = cubic, .allocates = false, .memory = may_share, .may_fail = false,
       .derivative_of = "inverse_dynamics", .lanes = false, .tape = false,
       .counts = with_losses(of_derivatives_of_forces, of_the_tree())},
      {.name = "forward_dynamics_second_derivatives",
       .purpose = "second partial derivatives of the accelerations, without loads",
       .units = "of a per units of the directions", .takes = {q, v, tau}, .choice = none, .entry = number,
       .shape = {nv, nv, nv}, .columns = false, .symbols = {"by q, q", "by q, v", "by v, v", "by tau, q"},
       .cost = cubic, .allocates = false, .memory = own, .may_fail = true,
       .derivative_of = "forward_dynamics", .lanes = false, .tape = false,
       .counts = with_losses(of_derivatives_of_accelerations, of_the_tree())},
      // clang-format on
  });
}();

/// The number of a row, which the compiler finds by its name; an unknown name does not compile.
struct Id {
  std::size_t index = 0;
  consteval Id(const char* name) {  // NOLINT(google-explicit-constructor): a name converts to an Id
    while (index < functions_of_state.size() && functions_of_state[index].name != name) ++index;
    if (index == functions_of_state.size()) throw "no row has this name";
  }
  /// The row of a name that is known at run time; empty if there is no such row.
  static constexpr std::optional<Id> of(std::string_view name) {
    Id found("poses");
    for (found.index = 0; found.index < functions_of_state.size(); ++found.index)
      if (functions_of_state[found.index].name == name) return found;
    return {};
  }
  constexpr const Words& words() const { return functions_of_state[index]; }
  constexpr bool operator==(const Id&) const = default;
};

/// Calls f<id>() for every row, in the order of the table, at compile time.
template <class F> constexpr void each_row(const F& f) {
  constexpr auto number = []<std::size_t index> {
    Id id("poses");
    id.index = index;
    return id;
  };
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    (f.template operator()<number.template operator()<k>()>(), ...);
  }
  (std::make_index_sequence<functions_of_state.size()>());
}

}  // namespace axode::catalog
