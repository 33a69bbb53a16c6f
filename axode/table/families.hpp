#pragma once
#include <string_view>

#include "axode/table/words.hpp"

/// Descriptions of how functions treat properties of mechanisms (loops, springs, ...), which whole families
/// of functions share. A Count says whether a function takes one property into account, and a Counts has a
/// Count for each property.
namespace axode::catalog::table {

/// Advice in the documentation of functions that ignore the forces of springs, dampers and stops.
inline constexpr std::string_view add_springs = "spring_forces(q, v) are to be added to tau",
                                  subtract_springs = "spring_forces(q, v) are to be subtracted from tau";
/// How functions that compute accelerations treat prescribed motions: they refuse models with prescribed
/// motions, because the accelerations then depend on the time, which is no argument. Functions whose
/// arguments are accelerations ignore prescribed motions instead.
inline constexpr Count at_a_time =
    refused("simulate and forward_dynamics_at count them, because they know the time");
/// Treatment of drives with states: their forces are part of the argument tau.
inline constexpr Count forces_of_drives = of_the_tree("tau has their forces, which DriveSystem computes");
/// Functions of a state (q, v) ignore couplings with play: the state does not say which end is touched.
inline constexpr Count free_plays = of_the_tree("simulate counts them");
/// Functions of a state (q, v) ignore contacts and hard stops, which act by impulses over a time step.
inline constexpr Count without_contacts =
    of_the_tree("simulate with contact and ContactDynamics count contacts and hard stops");
/// For functions that include damping and dry friction but refuse gear losses, which depend on gear forces.
inline constexpr Count without_gears{
    Word::partly, "losses of gears are refused; inverse_dynamics, forward_dynamics and simulate count them"};
/// Returns `counts` with another treatment of one property.
consteval Counts with(Counts counts, Count Counts::*property, Count treatment) {
  counts.*property = treatment;
  return counts;
}
/// Quantities of the cut tree, which are defined without any of the properties.
inline constexpr Counts of_motion{.loops = of_the_tree(),
                                  .passive_joints = of_the_tree(),
                                  .springs = of_the_tree(),
                                  .joint_losses = of_the_tree(),
                                  .motions = of_the_tree(),
                                  .drives = of_the_tree(),
                                  .plays = of_the_tree(),
                                  .contacts = of_the_tree()};
inline constexpr Counts of_loads = with(of_motion, &Counts::joint_losses, without_gears);
inline constexpr Counts of_columns =
    with(of_motion, &Counts::loops, of_the_tree("loops allow only velocities v with loop_jacobian(q) v = 0"));
inline constexpr Counts of_terms = with(
    of_motion, &Counts::loops,
    of_the_tree("independent_equations has the terms that belong to independent velocities of closed loops"));
inline constexpr Counts of_gravity = with(
    of_motion, &Counts::loops,
    of_the_tree("inverse_dynamics with v = a = 0 gives the drive forces that hold a mechanism with loops"));
inline constexpr Counts of_springs = with(of_motion, &Counts::springs, counted);
/// Quantities of the tree that only loops change.
inline constexpr Counts of_loops = with(of_motion, &Counts::loops, counted);
inline constexpr Counts of_forces{
    .loops = counted,
    .passive_joints = {Word::optional, "a LoopWorkspace, or drives in Python, leaves them without forces"},
    .springs = of_the_tree(subtract_springs),
    .joint_losses = optional,
    .motions = of_the_tree("tau has the forces that they take"),
    .drives = forces_of_drives,
    .plays = free_plays,
    .contacts = without_contacts};
inline constexpr Counts of_wrenches = with(of_loops, &Counts::joint_losses, optional);
inline constexpr Counts of_accelerations{.loops = counted,
                                         .passive_joints = of_the_tree(),
                                         .springs = of_the_tree(add_springs),
                                         .joint_losses = optional,
                                         .motions = at_a_time,
                                         .drives = forces_of_drives,
                                         .plays = free_plays,
                                         .contacts = without_contacts};
inline constexpr Counts of_variations_of_accelerations =
    with(of_accelerations, &Counts::joint_losses, without_gears);
inline constexpr Counts of_impulses =
    with(of_loops, &Counts::motions, refused("reduced locks the joints that they move"));
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
    .loops = refused("forward_dynamics_derivatives and its products with vectors count them"),
    .passive_joints = of_the_tree(),
    .springs = of_the_tree(add_springs),
    .joint_losses = without_gears,
    .motions = at_a_time,
    .drives = forces_of_drives,
    .plays = free_plays,
    .contacts = without_contacts};

}  // namespace axode::catalog::table
