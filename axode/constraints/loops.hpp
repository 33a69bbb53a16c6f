#pragma once
#include <memory>

#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

/// Closed loops. A mechanism is cut to a tree; a loop joint between bodies i and j leaves a subgroup of SE(3)
/// free, and the wrenches W that are reciprocal to it close the loop: W λ acts on j and -W λ on i. The rows
///   A = Wᵀ (J_j - J_i),   A v = 0,   A a + γ = 0
/// and their multipliers λ are numbers of the loop joint, the same in all representations: six less its
/// degrees of freedom, couples about x and y before forces along x, y and z of its frame on j, whose z is the
/// axis.
namespace axode {

template <class T> class LoopSystem;

/// Scratch memory of one thread for a mechanism with loops. A function that takes one instead of a Workspace
/// counts the loops.
template <class T = double> class LoopWorkspace {
 public:
  explicit LoopWorkspace(const Model& model);
  ~LoopWorkspace();
  /// A copy is made for the same model and shares no memory.
  LoopWorkspace(const LoopWorkspace& other);
  LoopWorkspace(LoopWorkspace&&) noexcept;
  LoopWorkspace& operator=(const LoopWorkspace& other);
  LoopWorkspace& operator=(LoopWorkspace&&) noexcept;

  /// Throws std::invalid_argument if it was made for another model.
  LoopSystem<T>& system(const Model& model);

 private:
  std::unique_ptr<LoopSystem<T>> system_;
};

/// r(q) (loops().residuals): 0 if the loops are closed, rad and m. It is smooth along all motions of the loop
/// joints, however far (D6.2). A rolling contact has a residual for the distance only. O(n).
template <class T>
void loop_residual(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> r);

/// A(q), loops().rows × nv, row by row: A v = 0 keeps the loops closed (D6.6). O(n + m d), and m nv to write
/// it.
template <class T>
void loop_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> A);

/// R(q), loops().residuals × nv: r' = R v, exactly (D6.4). If the loops are closed, R consists of the rows of
/// A that have a residual.
template <class T>
void loop_residual_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                            std::type_identity_t<std::span<T>> R);

/// The product of the second derivatives of Σ λ_k r_k with a velocity: the rate of R(q)ᵀ λ (nv) as q moves
/// with w (nv). Exact; it is the product with the Hessian if every velocity is the rate of a coordinate. O(n
/// + m d).
template <class T>
void loop_hessian_product(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                          Numbers<T> w, std::type_identity_t<std::span<T>> product);

/// γ(q, v) (loops().rows): (A v)' = A a + γ, exactly, also if the loops are open (D6.7). O(n).
template <class T>
void loop_bias(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
               std::type_identity_t<std::span<T>> gamma);

}  // namespace axode
