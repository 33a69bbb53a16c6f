#pragma once
#include <memory>

#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/scalar/instruction_set.hpp"

/// Closed loops. A mechanism is cut to a tree; a loop joint between bodies i and j leaves a subgroup of SE(3)
/// free, and the wrenches W that are reciprocal to it close the loop: W λ acts on j and -W λ on i. The rows
///   A = Wᵀ (J_j - J_i),   A v = 0,   A a + γ = 0
/// and their multipliers λ do not depend on a representation. A loop joint has six rows less its degrees of
/// freedom: couples about x and y, then forces along x, y and z, in its frame on j, whose z is the axis.
namespace axode {

template <class T> class LoopSystem;

/// Scratch memory of one thread for a mechanism with loops. A function that takes a LoopWorkspace instead of
/// a Workspace takes loops into account.
template <class T = double> class AXODE_ENTRY LoopWorkspace {
 public:
  explicit LoopWorkspace(const Model& model);
  ~LoopWorkspace();
  /// A copy is made for the same model and shares no memory.
  LoopWorkspace(const LoopWorkspace& other);
  LoopWorkspace(LoopWorkspace&&) noexcept;
  LoopWorkspace& operator=(const LoopWorkspace& other);
  LoopWorkspace& operator=(LoopWorkspace&&) noexcept;

  /// The loop system of this workspace. Throws std::invalid_argument if the workspace was made for another
  /// model.
  LoopSystem<T>& system(const Model& model);

 private:
  std::unique_ptr<LoopSystem<T>> system_;
};

/// Computes the residual r(q) (loops().residuals numbers, rad and m), which is 0 if the loops are closed. It
/// is smooth along all motions of the loop joints, however far (D6.2). A rolling contact has a residual for
/// the distance only. O(n).
template <class T>
void loop_residual(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> r);

/// Computes the matrix A(q) of all rows, loops().rows × nv, row by row: velocities with A v = 0 keep the
/// loops closed (D6.6). O(n + m d), and O(m nv) to write the matrix.
template <class T>
void loop_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> A);

/// Computes the Jacobian R(q) of the residual, loops().residuals × nv: r' = R v, exactly, also if the loops
/// are open (D6.4). If the loops are closed, R consists of the rows of A that have a residual.
template <class T>
void loop_residual_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                            std::type_identity_t<std::span<T>> R);

/// Computes the rate of R(q)ᵀ λ (nv) as q moves with the velocities w (nv): the product of the second
/// derivatives of Σ λ_k r_k with w. It is exact. If every velocity is the rate of a coordinate, it is the
/// product of the Hessian with w. O(n + m d).
template <class T>
void loop_hessian_product(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                          Numbers<T> w, std::type_identity_t<std::span<T>> product);

/// Computes γ(q, v) (loops().rows numbers) of (A v)' = A a + γ, exactly, also if the loops are open (D6.7).
/// O(n).
template <class T>
void loop_bias(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
               std::type_identity_t<std::span<T>> gamma);

}  // namespace axode
