#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Derivatives with respect to geometric parameters π (Müller, section 6.2), six for each body i. Let B_i be
/// the pose, relative to the predecessor p, of the frame that body i has while its joint is at zero, and X_i
/// the screws of the joint in this frame. The parameters change B_i to B_i exp(U π), so that C_i = C_p B_i
/// exp(U π) exp(X_i q_i), where U is one of the six unit screws of this frame, angular before linear. X_i,
/// the inertia in the body's frame and the components of loads do not change. Units are those of the result
/// per rad and per m. No allocation. All functions throw std::invalid_argument for a wrong size, quaternions
/// that are not of unit norm, and a load on a frame that does not exist.
namespace axode {

/// Computes ∂τ/∂π of the forces τ of inverse dynamics at (q, v, a): nv × n_bodies × 6 numbers, [component,
/// body - 1, parameter]. The six geometric parameters π of a body displace its joint and its subtree relative
/// to the predecessor, along the unit screws of the frame that the body has while its joint is at zero.
/// O(n d) on paths of d velocities. See (D1.18) of docs/derivations.
template <class T>
void inverse_dynamics_geometry_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                           Numbers<T> v, Numbers<T> a,
                                           std::type_identity_t<std::span<T>> dtau,
                                           const std::type_identity_t<Loads<T>>& loads = {});
/// Computes ∂a/∂π of the accelerations a of forward dynamics at (q, v, τ): nv × n_bodies × 6 numbers,
/// [component, body - 1, parameter]. The six geometric parameters π of a body displace its joint and its
/// subtree relative to the predecessor, along the unit screws of the frame that the body has while its joint
/// is at zero. O(n) for each parameter. The results are NaN if the returned status is not ok().
template <class T>
Solvability forward_dynamics_geometry_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                                  Numbers<T> v, Numbers<T> tau,
                                                  std::type_identity_t<std::span<T>> da,
                                                  const std::type_identity_t<Loads<T>>& loads = {});

/// Computes the gradient of w·τ, a weighted sum of the forces of inverse dynamics, by the geometric
/// parameters π: n_bodies × 6 numbers. The six geometric parameters π of a body displace its joint and its
/// subtree relative to the predecessor, along the unit screws of the frame that the body has while its joint
/// is at zero. O(n). See (D1.23) of docs/derivations.
template <class T>
void inverse_dynamics_geometry_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                   Numbers<T> a, Numbers<T> w, std::type_identity_t<std::span<T>> gradient,
                                   const std::type_identity_t<Loads<T>>& loads = {});
/// Computes the gradient of Σ w_c a_c, a weighted sum of the accelerations of forward dynamics, by the
/// geometric parameters π: n_bodies × 6 numbers. The six geometric parameters π of a body displace its joint
/// and its subtree relative to the predecessor, along the unit screws of the frame that the body has while
/// its joint is at zero. O(n). The gradient is NaN if the returned status of the forward dynamics is not
/// ok().
template <class T>
Solvability forward_dynamics_geometry_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                          Numbers<T> v, Numbers<T> tau, Numbers<T> w,
                                          std::type_identity_t<std::span<T>> gradient,
                                          const std::type_identity_t<Loads<T>>& loads = {});

/// Computes how each geometric parameter π displaces a place, that is a frame on a body: the body-fixed
/// twists C⁻¹ ∂C/∂π of its pose C, 6 × n_bodies × 6 numbers, [component, body - 1, parameter]. The six
/// geometric parameters π of a body displace its joint and its subtree relative to the predecessor, along the
/// unit screws of the frame that the body has while its joint is at zero. The twists are 0 unless the place
/// is in the subtree of the body. O(d) on a path of d bodies, and the time to write the zeros.
template <class T>
void frame_geometry_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<T>> J);
/// Computes the derivatives of the body-fixed Jacobian of a place, that is a frame on a body, by the
/// geometric parameters π: n_bodies × 6 × nv twists, [body - 1, parameter, velocity]. The six geometric
/// parameters π of a body displace its joint and its subtree relative to the predecessor, along the unit
/// screws of the frame that the body has while its joint is at zero. O(d²) on a path of d velocities, and the
/// time to write the zeros.
template <class T>
void jacobian_geometry_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                   const std::type_identity_t<Place<T>>& place,
                                   std::type_identity_t<std::span<Twist<BodyFixed, T>>> dJ);

}  // namespace axode
