#pragma once
#include "axode/batch.hpp"
#include "axode/contact/contact_shapes.hpp"

namespace axode::batch {

/// Integrates N motions with contact, K steps of equal length (s) each, see axode::simulate_contact(). tau
/// has nv K N numbers, which are constant in each step; q_out and v_out receive (K + 1) states for each
/// motion, beginning with the given one, and `certificates` the certificate of each step, K N numbers, unless
/// it is empty. If a motion cannot continue, its later states and certificates are NaN. The monitor is asked
/// before each step of the calling thread. If it ends the call, the count of finished motions is 0.
///
/// The shapes must be those of the model, as `ContactShapes(model, hull_of_mesh)`. With joint_losses damping
/// and dry friction of joints act. Each thread has memory of a fixed size, which all of its motions use one
/// after the other; no step allocates, see ContactStep. The results do not depend on the number of threads.
/// Throws std::invalid_argument for what simulate_contact() refuses and for arrays of another size.
Outcome rollout_with_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                             std::span<const double> v, std::span<const double> tau, double step,
                             std::span<double> q_out, std::span<double> v_out,
                             std::span<double> certificates = {}, int threads = 1,
                             const Monitor& monitor = {}, bool joint_losses = false);

/// Integrates N motions with contact of K steps under a drive that all motions share. Each thread has a copy
/// of the drive. Throws std::invalid_argument if the drive is empty.
Outcome rollout_with_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                             std::span<const double> v, const Drive& drive, std::size_t K, double step,
                             std::span<double> q_out, std::span<double> v_out,
                             std::span<double> certificates = {}, int threads = 1,
                             const Monitor& monitor = {}, bool joint_losses = false);

}  // namespace axode::batch
