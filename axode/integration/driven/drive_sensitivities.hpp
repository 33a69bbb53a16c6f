#pragma once
#include <functional>
#include <span>

#include "axode/drives/drive_system.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Derivatives of the motion of a mechanism with drives that have states, integrated from time t in K equal
/// steps by the method of batch::rollout() under drive forces tau that are constant in each step. They are
/// those of the numerical method. If the law of a drive changes its form, for example at a limit, they take
/// into account that the time of the change depends on the state (D17.20). Two effects at such a change are
/// neglected: jumps of states, and an explicit dependence of laws on time other than through inputs that are
/// functions of time. Displacements and gradients of q are left-trivialised, along q ⊕ ε dq. The components
/// of loads are constant in the representation in which they are given. If loads.joint_losses is set, joint
/// damping and friction act; Coulomb friction has the derivative 0. Springs, dampers and stops act.
///
/// If the initial states x of the drives are empty, the drives choose them, and they are taken as independent
/// of q and v. If the returned status is not ok(), because the motion cannot continue, because laws change
/// their forms without end or because monitor() returned false, all results are NaN. The functions allocate.
/// They throw std::invalid_argument for wrong sizes, an initial time or state that is not finite, quaternions
/// that are not of unit norm, a load on a frame that does not exist, step <= 0, a faulty Butcher tableau,
/// results that share memory with arguments, and mechanisms with loops, prescribed motions or couplings with
/// play.
namespace axode {

/// Receives the states (q, v, x) of a motion of K steps, K + 1 rows each, where x are the nx states of the
/// drives. It also receives the derivatives of the state at the end of each step, row by row: A (n × n with n
/// = 2nv + nx) by the state at the start of the step, B (n × nv) by the drive forces τ, and C (n × nu) by
/// constants that are added during the step to the inputs of the drives. Only the nu inputs that are
/// functions of time have a column, in the order of their drives; inputs that are the output of another drive
/// do not. The first nv rows, and columns of A, are those of q, and the next nv those of v. The spans must
/// not overlap.
struct DriveRolloutDerivatives {
  std::span<double> q, v, x, A, B, C;
};
/// Computes a motion of K steps of length `step` (s) that begins at time t (s) in the state (q, v, x), with
/// the states x of the drives (nx numbers, or none to let the drives choose), under the drive forces `tau` (K
/// rows of nv numbers). Also computes, for each step, the derivatives of the state at its end by the state at
/// its start, by the drive forces, and by constants that are added during the step to the inputs of the
/// drives, for the inputs that are functions of time. Each stage of the Runge-Kutta method costs O(n³) for n
/// = 2nv + nx. If monitor() returns false, the computation ends, and all results are NaN.
Solvability rollout_derivatives_with_drives(const Model& model, const DriveSystem& drives, double t,
                                            std::span<const double> q, std::span<const double> v,
                                            std::span<const double> x, std::span<const double> tau,
                                            double step, const DriveRolloutDerivatives& out,
                                            const Loads<double>& loads = {},
                                            const Tableau& method = runge_kutta(4),
                                            const std::function<bool()>& monitor = {});

/// Displacements of the data of a motion of K steps: of the initial q and v (nv numbers each) and x (the nx
/// states of the drives), of the drive forces τ (K rows of nv numbers, one row for each step), and of those
/// nu inputs u of the drives that are functions of time (K rows of nu numbers, which are added to the inputs
/// during each step).
struct DriveTangents {
  std::span<const double> q, v, x, tau, u;
};
/// Displacements of the states of a motion, or gradients by them: K + 1 rows each of nv, nv and nx numbers.
template <class T> struct DriveRows { std::span<T> q, v, x; };
/// Computes the displacements of all K + 1 states of a motion of K steps if its initial state, its drive
/// forces and its inputs are displaced by `d`. The first row is the displacement of the initial state. Each
/// stage of the method costs O(nv³) because of the derivatives of the accelerations.
Solvability rollout_jvp_with_drives(const Model& model, const DriveSystem& drives, double t,
                                    std::span<const double> q, std::span<const double> v,
                                    std::span<const double> x, std::span<const double> tau, double step,
                                    const DriveTangents& d, const DriveRows<double>& out,
                                    const Loads<double>& loads = {}, const Tableau& method = runge_kutta(4),
                                    const std::function<bool()>& monitor = {});

/// Receives the gradients of an objective by the initial q, v and x (the states of the drives), by the drive
/// forces (K rows of nv numbers for K steps) and by constants that are added in each step to those nu inputs
/// of the drives that are functions of time (K rows of nu numbers).
struct DriveGradients {
  std::span<double> q, v, x, tau, u;
};
/// Reverse-mode differentiation of a motion of K steps: from the gradients w of an objective by all K + 1
/// states, computes its gradients by the initial state, by the drive forces (K rows of nv numbers) and by
/// constants that are added in each step to the inputs of the drives (K rows of nu, for the inputs that are
/// functions of time). Stores the matrices of derivatives of every step.
Solvability rollout_vjp_with_drives(const Model& model, const DriveSystem& drives, double t,
                                    std::span<const double> q, std::span<const double> v,
                                    std::span<const double> x, std::span<const double> tau, double step,
                                    const DriveRows<const double>& w, const DriveGradients& gradient,
                                    const Loads<double>& loads = {}, const Tableau& method = runge_kutta(4),
                                    const std::function<bool()>& monitor = {});

}  // namespace axode
