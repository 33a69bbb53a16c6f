#pragma once
#include <memory>

#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {

template <class T> class ForceSeries;

/// Computes the time derivatives τ, τ', τ'', ... of the drive forces along a motion, to any order (Müller,
/// section 6.3). A motion is given by q and by the velocities v and their time derivatives v', v'', ..., in
/// the left-trivialised directions of the joints. Loads are constant in the representation in which they are
/// given. evaluate() does not allocate. Two threads must not use one object at the same time. See (D3.9) to
/// (D3.11) of docs/derivations.
template <class T = double> class AXODE_ENTRY InverseDynamicsRates {
 public:
  /// Allocates the memory for time derivatives of τ up to an order. Throws std::invalid_argument if the order
  /// is negative, and for a model with loops, for which the function inverse_dynamics_rates() must be called
  /// instead.
  InverseDynamicsRates(const Model& model, int order);
  ~InverseDynamicsRates();
  InverseDynamicsRates(InverseDynamicsRates&&) noexcept;
  InverseDynamicsRates& operator=(InverseDynamicsRates&&) noexcept;

  int order() const;

  /// Computes τ, τ', ... ((order + 1) nv numbers, row by row) from q and from `rates`, which are v, a, jerk,
  /// ... ((order + 2) nv numbers, row by row). `tau` and `rates` must not overlap. If loads.joint_losses is
  /// set, damping contributes to τ and to its derivatives; Coulomb friction contributes to τ only. O(n
  /// order²).
  void evaluate(Numbers<T> q, Numbers<T> rates, std::type_identity_t<std::span<T>> tau,
                const std::type_identity_t<Loads<T>>& loads = {});

 private:
  Model model_;
  std::unique_ptr<ForceSeries<T>> series_;
};

/// Computes τ, τ' and τ'' of inverse dynamics by the Newton-Euler recursion, differentiated twice, in the
/// representation Rep. `rates` are v, a, jerk and snap (4 nv numbers, row by row), and `tau` has 3 nv
/// numbers; the two must not overlap. O(n), no allocation. Throws std::invalid_argument for a wrong size and
/// for a model with loops. See (D3.1) to (D3.8) and (D3.15) to (D3.19) of docs/derivations.
template <class Rep, class T>
void second_order_inverse_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                   Numbers<T> rates, std::type_identity_t<std::span<T>> tau,
                                   const std::type_identity_t<Loads<T>>& loads = {});

/// Computes the time derivatives of the accelerations of forward dynamics: a, jerk, ... (`rates`, k rows of
/// nv numbers) from q, v and the forces τ, τ', ... (`forces`, k rows of nv numbers). Derivative j of τ is an
/// affine function of derivative j of a, with the mass matrix M as factor; hence one linear system with M is
/// solved for each row. O(n k³), plus the solution of the k linear systems; allocates. The results are NaN if
/// the status is not ok(). See (D3.12) of docs/derivations.
template <class T>
Solvability forward_dynamics_rates(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                   Numbers<T> forces, std::type_identity_t<std::span<T>> rates,
                                   const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
