#pragma once
#include <memory>

#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/scalar/instruction_set.hpp"

/// Closed loops: a spanning tree with additional loop joints. The constraint wrenches of a loop joint
/// between bodies i and j are the columns of W. They are reciprocal to the motions that the joint leaves
/// free. For multipliers λ, the wrench W λ acts on body j and -W λ on body i. The loop equations
///   A v = 0,   A a + γ = 0,   A = Wᵀ (J_j - J_i)
/// with the Jacobians J of the bodies and γ = A' v are the same in all representations. A loop joint has
/// six equations minus the number of its degrees of freedom. If its free motions form a subgroup of SE(3),
/// the equations are in the order of the wrenches: couples about x, y and z, then forces along x, y and z,
/// without the wrenches that the joint does not transmit. The axes are those of the joint's frame on body
/// j, whose z is the axis of the joint.
namespace axode {

template <class T> class LoopSystem;

/// Scratch memory of one thread for a mechanism with loops. Functions that take a LoopWorkspace take loops
/// into account. Unless they say so, they do not check that q and v keep the loops closed: then
/// loop_residual() and A v are 0, and assemble() computes such q and v. Functions that take a Workspace
/// compute with the spanning tree.
template <class T = double> class AXODE_ENTRY LoopWorkspace {
 public:
  explicit LoopWorkspace(const Model& model);
  ~LoopWorkspace();
  /// Makes a workspace for the same model. It shares no memory with `other`.
  LoopWorkspace(const LoopWorkspace& other);
  LoopWorkspace(LoopWorkspace&&) noexcept;
  LoopWorkspace& operator=(const LoopWorkspace& other);
  LoopWorkspace& operator=(LoopWorkspace&&) noexcept;

  /// The system of the loop equations. Throws std::invalid_argument for a workspace of another model.
  LoopSystem<T>& system(const Model& model);

 private:
  std::unique_ptr<LoopSystem<T>> system_;
};

/// Computes the residual r(q) of the loops (loops().residuals numbers in all, rad and m), which is 0 if the
/// loops are closed. It is smooth along all motions of the loop joints, however far (D6.2). A rolling contact
/// has a residual for the distance from the plane only, and a belt has none. O(n).
template <class T>
void loop_residual(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> r);

/// Computes the Jacobian A(q) of all loop equations, row by row (nv numbers for each of the loops().rows
/// equations): velocities with A v = 0 keep the loops closed (D6.6). O(n + m d) for m equations on paths of d
/// joints, and O(m nv) to write the matrix.
template <class T>
void loop_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                   std::type_identity_t<std::span<T>> A);

/// Computes the Jacobian R(q) of the residual r(q) of the loops (a row of nv numbers for each of the
/// loops().residuals entries of r), with r' = R v. It is exact also if the loops are open (D6.4).
template <class T>
void loop_residual_jacobian(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                            std::type_identity_t<std::span<T>> R);

/// Computes the rate of R(q)ᵀ λ (nv) as q moves with the velocities w (nv), where R is the Jacobian of the
/// residual r of the loops and λ is constant (a number for each of the loops().residuals entries of r). This
/// is the exact product of w with the matrix of second derivatives of Σ λ_k r_k. O(n + m d) for m residuals
/// on paths of d joints.
template <class T>
void loop_hessian_product(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                          Numbers<T> w, std::type_identity_t<std::span<T>> product);

/// Computes the bias γ(q, v) = A' v of the loop equations A v = 0, A a + γ = 0 (a number for each of the
/// loops().rows equations). It is exact also if the loops are open (D6.7). O(n).
template <class T>
void loop_bias(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
               std::type_identity_t<std::span<T>> gamma);

}  // namespace axode
