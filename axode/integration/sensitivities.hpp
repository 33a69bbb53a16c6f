#pragma once
#include <functional>
#include <span>

#include "axode/integration/tableau.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Sensitivities of a motion that an explicit method on the group of configurations integrates in equal steps
/// under drive forces that are constant in each step. They are the exact derivatives of the numerical method,
/// computed from those of forward dynamics. Displacements and gradients of q are left-trivialised, along q ⊕
/// ε dq. The components of loads are constant in the representation in which they are given. If
/// loads.joint_losses is set, the damping and Coulomb friction of joints act; friction has the derivative 0.
/// Springs, dampers and stops of the model act; with springs a stage of the method costs O(n²). Throws
/// std::invalid_argument for wrong sizes, quaternions that are not of unit norm, a load on a frame that does
/// not exist, step <= 0, inconsistent coefficients of the method (its Butcher tableau), results that share
/// memory with arguments, and mechanisms with loops, prescribed motions, drives with states or couplings with
/// play. If accelerations cannot be computed or are not finite, the returned status is not ok(), and all
/// results are NaN.
namespace axode {

/// Receives the state (q, v) at the end of a step, and its derivatives A by the state at the start (2nv ×
/// 2nv) and B by the drive forces τ (2nv × nv), row by row. The first nv rows, and columns of A, are those of
/// q; the last nv are those of v. The spans must not overlap.
struct StepDerivatives {
  std::span<double> q, v, A, B;
};
/// Computes one step of length `step` (s) from the state (q, v) under the drive forces tau, and the
/// derivatives of the state at its end by the state at its start and by the drive forces. Each stage of the
/// method takes O(n²) and products of nv × nv with nv × 3nv matrices; allocates.
Solvability step_derivatives(const Model& model, Workspace<double>& workspace, std::span<const double> q,
                             std::span<const double> v, std::span<const double> tau, double step,
                             const StepDerivatives& end, const Loads<double>& loads = {},
                             const Tableau& method = runge_kutta(4));

/// A function that is called before each step. If it returns false, the computation ends, the results are
/// NaN, and not_finite is set in the returned status.
using Monitor = std::function<bool()>;

/// Computes the displacements of all states of a motion of K steps, under K rows of nv drive forces, if its
/// start q is displaced by dq, its initial velocity by dv and the forces by dtau (K nv numbers). dq_out and
/// dv_out receive K + 1 rows of nv numbers; the first rows are dq and dv. O(n) for each step.
Solvability rollout_jvp(const Model& model, std::span<const double> q, std::span<const double> v,
                        std::span<const double> tau, double step, std::span<const double> dq,
                        std::span<const double> dv, std::span<const double> dtau, std::span<double> dq_out,
                        std::span<double> dv_out, const Loads<double>& loads = {},
                        const Tableau& method = runge_kutta(4), const Monitor& monitor = {});

/// Receives the gradients of an objective: by q and v of the initial state (nv numbers each), by the drive
/// forces (K nv numbers for K steps) and by the geometric parameters (n_bodies × 6 numbers). The six
/// parameters of a body displace its joint and its subtree relative to the predecessor, along the unit
/// screws, angular before linear, of the frame that the body has while its joint is at zero. `geometry` may
/// be empty, and must be empty for models with springs between frames (std::invalid_argument). The spans must
/// not overlap.
struct RolloutGradients {
  std::span<double> q, v, tau, geometry = {};
};
/// Reverse-mode differentiation of a motion of K steps: from the gradients w_q and w_v of an objective by q
/// and v of each of the K + 1 states (K + 1 rows of nv numbers), computes its gradients by the initial state,
/// the drive forces and the geometric parameters. O(n) for each step. Only the states are stored; stages are
/// computed again.
Solvability rollout_vjp(const Model& model, std::span<const double> q, std::span<const double> v,
                        std::span<const double> tau, double step, std::span<const double> w_q,
                        std::span<const double> w_v, const RolloutGradients& gradient,
                        const Loads<double>& loads = {}, const Tableau& method = runge_kutta(4),
                        const Monitor& monitor = {});

}  // namespace axode
