#pragma once
#include "axode/batch.hpp"
#include "axode/contact/contact_shapes.hpp"

namespace axode::batch {

/// Integrates N motions with contact, K steps of equal length `step` (s) each with the method of
/// axode::simulate_contact(): impulses at both ends of a step. tau has nv K N numbers, the drive forces,
/// which are constant in each step. q_out and v_out receive (K + 1) states for each motion, beginning with
/// the given initial state. Unless it is empty, `certificates` receives the relative residual of the laws of
/// contact for each step of each motion (K N numbers, see Trajectory::certificates). Each array has one
/// motion after the other, and each motion one step after the other. If a motion cannot continue, its later
/// states and certificates are NaN.
///
/// The monitor is the caller's function monitor(done, of) that can end a long call by returning false. It is
/// called in the calling thread, before and during steps. `of` is N; `done` is always 0, because finished
/// motions are not counted. If the monitor ends the call, Outcome::done is 0 as well.
///
/// `shapes` are the collision shapes of the model. If `joint_losses` is set, damping and dry friction of
/// joints act. Drives with states act as in simulate_contact(), with which motions agree to the last bit for
/// the same forces and times: a step is computed in parts, which end where a drive changes to another branch
/// of its law and where an input jumps. No step allocates after the first ones, and the results do not depend
/// on the number of threads. Throws std::invalid_argument for arguments that simulate_contact() refuses and
/// for arrays of a wrong size.
Outcome rollout_with_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                             std::span<const double> v, std::span<const double> tau, double step,
                             std::span<double> q_out, std::span<double> v_out,
                             std::span<double> certificates = {}, int threads = 1,
                             const Monitor& monitor = {}, bool joint_losses = false,
                             const DriveMotions& drives = {});

/// Integrates N motions with contact under a drive that all motions share, K steps of length `step` (s) each.
/// Each thread has a copy of the drive. Throws std::invalid_argument if the drive is empty.
Outcome rollout_with_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                             std::span<const double> v, const Drive& drive, std::size_t K, double step,
                             std::span<double> q_out, std::span<double> v_out,
                             std::span<double> certificates = {}, int threads = 1,
                             const Monitor& monitor = {}, bool joint_losses = false,
                             const DriveMotions& drives = {});

}  // namespace axode::batch
