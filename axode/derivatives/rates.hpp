#pragma once
#include <memory>

#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {

template <class T> class ForceSeries;

/// The time derivatives τ, τ', τ'', ... of the drive forces along a motion, to any order (section 6.3).
/// forward_dynamics_rates() computes the inverse. A motion is q and the derivatives of the velocities, v, v',
/// v'', ..., all in the joints' left-trivialised directions; loads are constant in the representation in
/// which they are given. Evaluation does not allocate; an object is for one thread. See (D3.9) to (D3.11) of
/// docs/derivations.
template <class T = double> class AXODE_ENTRY InverseDynamicsRates {
 public:
  /// Prepares the derivatives of τ up to an order. Throws std::invalid_argument if it is negative, and for a
  /// model with loops, which inverse_dynamics_rates() counts.
  InverseDynamicsRates(const Model& model, int order);
  ~InverseDynamicsRates();
  InverseDynamicsRates(InverseDynamicsRates&&) noexcept;
  InverseDynamicsRates& operator=(InverseDynamicsRates&&) noexcept;

  int order() const;

  /// Computes τ, τ', ... ((order + 1) nv numbers, row by row) from q and from `rates`, which are v, a, jerk,
  /// ... ((order + 2) nv numbers, row by row). The two must not overlap. With loads.joint_losses, damping
  /// contributes to τ and to its derivatives; Coulomb friction contributes to τ only. O(n order²).
  void evaluate(Numbers<T> q, Numbers<T> rates, std::type_identity_t<std::span<T>> tau,
                const std::type_identity_t<Loads<T>>& loads = {});

 private:
  Model model_;
  std::unique_ptr<ForceSeries<T>> series_;
};

/// Computes τ, τ' and τ'' by the Newton-Euler recursion, differentiated twice, in the representation Rep,
/// which is BodyFixed or Hybrid. `rates` are v, a, jerk and snap, 4 nv numbers row by row, and tau has 3 nv,
/// which must not overlap them. The results are those of InverseDynamicsRates of order 2, also with loads and
/// losses. O(n), no allocation. See (D3.1) to (D3.8) of docs/derivations.
template <class Rep, class T>
void second_order_inverse_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                   Numbers<T> rates, std::type_identity_t<std::span<T>> tau,
                                   const std::type_identity_t<Loads<T>>& loads = {});

/// Computes the derivatives of forward dynamics in time: a, jerk, ... (`rates`, k rows of nv) from q, v and
/// τ, τ', ... (`forces`, k rows of nv). Derivative k of τ is an affine function of derivative k of a, with
/// the matrix M; hence one linear system with M is solved for each row. O(n k³) for all rows, and one
/// solution for each; allocates. NaN if the status is not ok(). See (D3.12) of docs/derivations.
template <class T>
Solvability forward_dynamics_rates(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                   Numbers<T> forces, std::type_identity_t<std::span<T>> rates,
                                   const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
