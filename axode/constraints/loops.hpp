#pragma once
#include <memory>

#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

/// Closed loops. A mechanism is cut to a tree; a loop joint between bodies i and j leaves a subgroup of SE(3) free, and
/// the wrenches W that are reciprocal to it close the loop: W λ acts on j and -W λ on i. The rows
///   A = Wᵀ (J_j - J_i),   A v = 0,   A a + γ = 0
/// and their multipliers λ are numbers of the loop joint, the same in all representations: six less its degrees of
/// freedom, couples about x and y before forces along x, y and z of its frame on j, whose z is the axis.
namespace axode {

template <class T> class LoopSystem;

/// Scratch memory of one thread for a mechanism with loops. Where a function takes one in place of a Workspace it counts
/// the loops.
template <class T = double> class LoopWorkspace {
 public:
  explicit LoopWorkspace(const Model& model);
  ~LoopWorkspace();
  /// A copy is made for the same model and shares no memory.
  LoopWorkspace(const LoopWorkspace& other);
  LoopWorkspace(LoopWorkspace&&) noexcept;
  LoopWorkspace& operator=(const LoopWorkspace& other);
  LoopWorkspace& operator=(LoopWorkspace&&) noexcept;

  /// Throws std::invalid_argument where it was made for another model.
  LoopSystem<T>& system(const Model& model);

 private:
  std::unique_ptr<LoopSystem<T>> system_;
};

/// r(q) (loops().residuals): 0 where the loops are closed, rad and m; smooth along all motions of the loop joints, however
/// far. Contacts that roll have one for the distance alone. O(n).
template <class T>
void loop_residual(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> r);

/// A(q), loops().rows × nv, row by row: what must be 0 of velocities is A v. O(n + m d), and m nv to write it.
template <class T>
void loop_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> A);

/// R(q), loops().residuals × nv: r' = R v, exactly. R = A, but for rolling rows, where the loops are closed.
template <class T>
void loop_residual_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                            std::type_identity_t<std::span<T>> R);

/// The product of the second derivatives of Σ λ_k r_k with a velocity: the rate of R(q)ᵀ λ (nv) as q moves with w (nv).
/// Exact; the Hessian's product where every velocity is the rate of a coordinate. O(n + m d).
template <class T>
void loop_hessian_product(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                          Numbers<T> w, std::type_identity_t<std::span<T>> product);

/// γ(q, v) (loops().rows): (A v)' = A a + γ, exactly, closed or not. O(n).
template <class T>
void loop_bias(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
               std::type_identity_t<std::span<T>> gamma);

}  // namespace axode
