#pragma once
#include <functional>
#include <span>

#include "axode/integration/tableau.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Sensitivities of a motion in steps of one length, by an explicit method on the group of configurations as
/// in simulate_fixed(), under drive forces that are constant in each step: the exact derivatives of what the
/// method computes, through those of forward dynamics. Displacements and gradients of q are left-trivialised,
/// along q ⊕ ε dq. Loads and losses act as in forward_dynamics_derivatives(), and the springs, dampers and stops of
/// the model as in simulate_fixed(): with them a stage costs O(n²). Throws std::invalid_argument
/// for wrong sizes, a quaternion off 1, a load on a frame that does not exist, step <= 0, a faulty tableau
/// and results that share memory with what is still read. Where the status is not ok(), because accelerations
/// could not be found or are not finite on the way, all results are NaN.
namespace axode {

/// Where the end (q, v) of a step goes, and its derivatives A by the state, 2nv × 2nv, and B by τ, 2nv × nv,
/// row by row, displacements before velocities. They may not overlap.
struct StepDerivatives {
  std::span<double> q, v, A, B;
};
/// A step from (q, v) under tau. O(n²) for each stage, and products of nv × nv matrices with 3nv columns, for which it
/// allocates.
Solvability step_derivatives(const Model& model, Workspace<double>& workspace, std::span<const double> q,
                             std::span<const double> v, std::span<const double> tau, double step,
                             const StepDerivatives& end, const Loads<double>& loads = {},
                             const Tableau& method = runge_kutta(4));

/// Asked before each step whether to go on; where it says no, results are NaN and not_finite is told.
using Monitor = std::function<bool()>;

/// What becomes of the states of a motion of K steps, K nv drive forces, where its start is displaced by dq,
/// v by dv and the forces by dtau, K nv numbers. dq_out and dv_out get (K + 1) nv, the given ones in front.
/// O(n) a step, without matrices.
Solvability rollout_jvp(const Model& model, std::span<const double> q, std::span<const double> v,
                        std::span<const double> tau, double step, std::span<const double> dq,
                        std::span<const double> dv, std::span<const double> dtau, std::span<double> dq_out,
                        std::span<double> dv_out, const Loads<double>& loads = {},
                        const Tableau& method = runge_kutta(4), const Monitor& monitor = {});

/// Where gradients by the start, nv numbers each, the drive forces, K nv, and the geometric parameters,
/// n_bodies × 6 as in geometry_derivatives.hpp, go; the last where they are wanted, which of models with springs
/// between frames throws std::invalid_argument. They may not overlap.
struct RolloutGradients {
  std::span<double> q, v, tau, geometry = {};
};
/// The gradient of Σ w_q·δq + w_v·δv over all states, (K + 1) nv weights each, of a motion of K steps. O(n) a
/// step, without matrices; keeps the states, and finds the stages again on the way back.
Solvability rollout_vjp(const Model& model, std::span<const double> q, std::span<const double> v,
                        std::span<const double> tau, double step, std::span<const double> w_q,
                        std::span<const double> w_v, const RolloutGradients& gradient,
                        const Loads<double>& loads = {}, const Tableau& method = runge_kutta(4),
                        const Monitor& monitor = {});

}  // namespace axode
