#pragma once
#include <span>
#include <string>

#include "axode/contact/contact_shapes.hpp"
#include "axode/integration/sensitivities.hpp"
#include "axode/integration/trajectory.hpp"

/// Sensitivities of motions with contact, integrated as by simulate_contact() in equal steps under drive
/// forces that are constant in each step. They are the exact derivatives of the numerical method, by implicit
/// differentiation of the equations of a step (D11.19 to D11.23, D11.36 to D11.38): which contacts touch,
/// stick, slide and bounce is taken as unchanged by a small displacement. At a gap of 0, the derivative is
/// that of a displacement that opens the gap. Displacements and gradients of q are left-trivialised, along q
/// ⊕ ε dq. Damping and dry friction of joints, springs, hard stops and closed loops act, and prescribed
/// motions are followed from time 0, with steps divided where they jump.
///
/// Throws std::invalid_argument for wrong sizes, a state that is not finite or quaternions that are not of
/// unit norm, step <= 0, shapes of another model, drives with states, couplings with play, states that do not
/// follow prescribed motions, and results that share memory with arguments. Contact points must have a
/// formula that can be differentiated. This is the case for planes with any shape, spheres and capsules with
/// each other, boxes with spheres, and two boxes if a face of one of them touches. If a contact has no such
/// formula, or a step fails, ContactSensitivity::failure says so, and all results are NaN.
namespace axode {

/// Whether a computation of sensitivities failed, and whether the derivatives exist.
struct [[nodiscard]] ContactSensitivity {
  Failure failure = {};    ///< with the time and the reason
  double certificate = 0;  ///< largest one of all steps, see certificate()
  /// Whether all derivatives exist. If contacts share a load and slide in different directions, they may not.
  bool unique = true;
  /// Whether a contact, stop or dry friction was within rounding of the boundary between two branches of its
  /// law. The derivative is then that of the branch that was taken.
  bool at_kink = false;
  bool ok() const { return !failure; }
};

/// Numbers for the parameters of a mechanism with n collision shapes and b moving bodies, such as changes of
/// the parameters or gradients of an objective by them. The parameters are the surfaces of the shapes
/// (friction, restitution, thickness of a layer), the placement of the shapes, the inertia of the bodies, and
/// the geometry of the tree. Each span may be empty.
template <class T> struct ContactParameters {
  /// Numbers for the surfaces of the n shapes, with 3 n parameters: n coefficients of friction, n
  /// coefficients of restitution, and n thicknesses of a layer on each shape (m). A change of this thickness
  /// moves the surface of the shape outwards, like a change of the radius of a sphere or capsule, or of the
  /// height of a plane. Derivatives by the friction of a pair of shapes without friction, which do not exist,
  /// are given as 0.
  std::span<T> surfaces = {};
  /// Numbers for the placement of the n shapes on their bodies, with six parameters π_u for each shape, which
  /// displace it on its body (rad and m) along the unit screws U_u of its own frame, angular before linear.
  /// The pose P of the shape becomes P exp(Σ π_u U_u).
  std::span<T> placement = {};
  /// Numbers for the ten inertial parameters of each of the b moving bodies (kg, kg m, kg m²), see
  /// inertial_parameters.hpp.
  std::span<T> inertia = {};
  /// Numbers for the 6 b geometric parameters of the tree, such as changes of these parameters or derivatives
  /// by them. The six parameters of each of the b moving bodies displace its joint and its subtree relative
  /// to the predecessor (rad and m), along the unit screws, angular before linear, of the frame that the body
  /// has while its joint is at zero. For models with loops, prescribed motions or springs between frames the
  /// span must be empty, or std::invalid_argument is thrown.
  std::span<T> geometry = {};
};

/// Receives the states of a motion of K steps with contact, K + 1 rows of nq and of nv numbers, and for each
/// step, row by row, the derivatives of the state (q, v) at its end: A (2nv × 2nv) by the state at its start,
/// B (2nv × nv) by the drive forces τ, and C (2nv × 3 n for n collision shapes, or empty) by the surfaces of
/// the shapes, in the order of ContactParameters::surfaces: friction, restitution, and thickness of a layer
/// by which the surface moves outwards. Each span of `by` that is not empty receives derivatives by other
/// parameters (placement of the shapes, inertia of the bodies, or geometry of the tree), for each step 2nv
/// rows with a column for each parameter; by.surfaces must be empty. In all matrices the first nv rows, and
/// in A also the first nv columns, belong to q, and the last nv to v. The spans must not overlap.
struct ContactRolloutDerivatives {
  std::span<double> q, v, A, B, C = {};
  ContactParameters<double> by = {};
};
/// Computes a motion of K steps of length `step` (s) from the state (q, v) under K rows of nv drive forces,
/// and its derivatives by the first state and by the drive forces. Allocates; O(nv³ + m³) for a step with m
/// constraints (contacts, stops, dry friction, loops).
ContactSensitivity contact_rollout_derivatives(const Model& model, const ContactShapes& shapes,
                                               std::span<const double> q, std::span<const double> v,
                                               std::span<const double> tau, double step,
                                               const ContactRolloutDerivatives& out,
                                               const Monitor& monitor = {});

/// Computes how all states of a motion of K steps with contact, under K rows of nv drive forces, are
/// displaced if the data of the motion are displaced: the initial q by dq, the initial v by dv, the forces by
/// dtau (K nv numbers), and the parameters of the mechanism by the numbers in `parameters`. These are the
/// friction and restitution of the collision shapes, the thickness of a layer by which the surface of each
/// shape moves outwards, the placement of the shapes on their bodies, the inertia of the bodies, and the
/// geometry of the tree. dq_out and dv_out receive K + 1 rows of nv numbers; the first rows are dq and dv.
/// Allocates.
ContactSensitivity contact_rollout_jvp(const Model& model, const ContactShapes& shapes,
                                       std::span<const double> q, std::span<const double> v,
                                       std::span<const double> tau, double step, std::span<const double> dq,
                                       std::span<const double> dv, std::span<const double> dtau,
                                       std::span<double> dq_out, std::span<double> dv_out,
                                       const Monitor& monitor = {},
                                       const ContactParameters<const double>& parameters = {});

/// Reverse-mode differentiation of a motion of K steps with contact. w_q and w_v are the gradients of an
/// objective by q and v of each of the K + 1 states (K + 1 rows of nv numbers). `gradient` receives the
/// gradients of the objective by the initial q and v and by the drive forces; gradient.geometry must be
/// empty. Each span of `by_parameters` that is not empty receives the gradients by the parameters of its
/// kind: surfaces (friction, restitution, thickness of a layer) and placement of the collision shapes,
/// inertia of the bodies, or geometry of the tree. Stores 2 K nv (3 nv + p) numbers for p parameters.
/// Allocates.
ContactSensitivity contact_rollout_vjp(const Model& model, const ContactShapes& shapes,
                                       std::span<const double> q, std::span<const double> v,
                                       std::span<const double> tau, double step, std::span<const double> w_q,
                                       std::span<const double> w_v, const RolloutGradients& gradient,
                                       const Monitor& monitor = {},
                                       const ContactParameters<double>& by_parameters = {});

}  // namespace axode
