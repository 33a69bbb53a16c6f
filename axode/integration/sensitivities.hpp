#pragma once
#include <functional>
#include <span>

#include "axode/integration/tableau.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Sensitivities of a motion in steps of one length, by an explicit method on the group of configurations as
/// in simulate_fixed(), under drive forces that are constant in each step: the exact derivatives of the
/// numerical method, from those of forward dynamics. Displacements and gradients of q are left-trivialised,
/// along q ⊕ ε dq. Loads and losses act as in forward_dynamics_derivatives(), springs, dampers and stops as
/// in simulate_fixed(); with springs a stage costs O(n²). Throws std::invalid_argument for wrong sizes,
/// quaternions that are not of unit norm, a load on a frame that does not exist, step <= 0, a faulty tableau
/// and results that share memory with arguments. If the returned status is not ok(), because accelerations
/// could not be computed or are not finite, all results are NaN.
namespace axode {

/// Receives the end (q, v) of a step, and its derivatives A by the state (2nv × 2nv) and B by τ (2nv × nv),
/// row by row, displacements before velocities. They must not overlap.
struct StepDerivatives {
  std::span<double> q, v, A, B;
};
/// Computes a step from (q, v) under tau. O(n²) for each stage, and products of nv × nv matrices with 3nv
/// columns; allocates.
Solvability step_derivatives(const Model& model, Workspace<double>& workspace, std::span<const double> q,
                             std::span<const double> v, std::span<const double> tau, double step,
                             const StepDerivatives& end, const Loads<double>& loads = {},
                             const Tableau& method = runge_kutta(4));

/// Called before each step; if it returns false, the computation ends, results are NaN and the status has
/// not_finite.
using Monitor = std::function<bool()>;
using GoOn [[deprecated("use Monitor")]] = Monitor;

/// Computes the displacements of the states of a motion of K steps, under K nv drive forces, if its start is
/// displaced by dq, its initial velocity by dv and the forces by dtau (K nv). dq_out and dv_out receive (K +
/// 1) nv numbers, beginning with dq and dv. O(n) a step, without matrices.
Solvability rollout_jvp(const Model& model, std::span<const double> q, std::span<const double> v,
                        std::span<const double> tau, double step, std::span<const double> dq,
                        std::span<const double> dv, std::span<const double> dtau, std::span<double> dq_out,
                        std::span<double> dv_out, const Loads<double>& loads = {},
                        const Tableau& method = runge_kutta(4), const Monitor& monitor = {});

/// Receives the gradients by the start (nv numbers each for q and v), the drive forces (K nv) and the
/// geometric parameters (n_bodies × 6 as in geometry_derivatives.hpp, may be empty). For models with springs
/// between frames the latter throws std::invalid_argument. They must not overlap.
struct RolloutGradients {
  std::span<double> q, v, tau, geometry = {};
};
/// Computes the gradient of Σ w_q·δq + w_v·δv over all states, (K + 1) nv weights each, of a motion of K
/// steps. O(n) a step, without matrices; stores the states, and computes the stages again in the backward
/// pass.
Solvability rollout_vjp(const Model& model, std::span<const double> q, std::span<const double> v,
                        std::span<const double> tau, double step, std::span<const double> w_q,
                        std::span<const double> w_v, const RolloutGradients& gradient,
                        const Loads<double>& loads = {}, const Tableau& method = runge_kutta(4),
                        const Monitor& monitor = {});

}  // namespace axode
