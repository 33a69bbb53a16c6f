#pragma once
#include "axode/batch.hpp"
#include "axode/contact/contact_shapes.hpp"

namespace axode::batch {

/// Integrates N motions with contact, K steps of equal length `step` (s) each, with the method of
/// axode::simulate_contact(). The drive forces `tau` (nv K N numbers) are constant in each step. q_out and
/// v_out receive K + 1 states of each motion, the first of which is the initial state. `certificates` may be
/// empty, or receives for each step the relative residual of Signorini's and Coulomb's laws (K N numbers, see
/// Trajectory::certificates). In each array one motion follows the other, and within a motion one step
/// follows the other. If a motion cannot continue, its later states and certificates are NaN.
///
/// The monitor, a function of the caller, is called with the arguments 0 and N in the calling thread, before
/// and during steps; finished motions are not counted. If it returns false, the call ends, and Outcome::done
/// is 0.
///
/// `shapes` are the collision shapes of the model. If `joint_losses` is set, damping and dry friction of
/// joints act. For equal forces and times the motions are those of simulate_contact() to the last bit, also
/// with drives that have states: a step is divided where the law of a drive changes to another branch, and
/// where an input of a drive jumps. No step allocates after the first ones, and the results do not depend on
/// the number of threads. Throws std::invalid_argument for models, shapes and a step that simulate_contact()
/// refuses, for quaternions that are not of unit norm, for arrays of a wrong size, and for initial states
/// that do not close the loops or do not follow prescribed motions, which begin at time 0.
Outcome rollout_with_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                             std::span<const double> v, std::span<const double> tau, double step,
                             std::span<double> q_out, std::span<double> v_out,
                             std::span<double> certificates = {}, int threads = 1,
                             const Monitor& monitor = {}, bool joint_losses = false,
                             const DriveMotions& drives = {});

/// Integrates N motions with contact, K steps of length `step` (s) each, under the drive forces that the
/// function `drive` computes from the time and the state (q, v) of a motion. Each thread calls its own copy
/// of `drive`. Throws std::invalid_argument if `drive` is an empty function object.
Outcome rollout_with_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                             std::span<const double> v, const Drive& drive, std::size_t K, double step,
                             std::span<double> q_out, std::span<double> v_out,
                             std::span<double> certificates = {}, int threads = 1,
                             const Monitor& monitor = {}, bool joint_losses = false,
                             const DriveMotions& drives = {});

}  // namespace axode::batch
