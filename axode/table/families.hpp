#pragma once
#include <string_view>

#include "axode/table/words.hpp"

/// The treatment of the properties of mechanisms by families of functions.
namespace axode::catalog::table {

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
/// The treatment `counts` of all properties but joint losses, which have a treatment of their own.
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
    .loops = refused("forward_dynamics_derivatives and its products with vectors count them"),
    .passive_joints = of_the_tree(),
    .springs = of_the_tree(add_springs),
    .joint_losses = without_gears,
    .motions = at_a_time,
    .drives = forces_of_drives,
    .plays = free_plays,
    .contacts = without_contacts};

}  // namespace axode::catalog::table
