#pragma once
#include "axode/dynamics/inverse_dynamics_recursion.hpp"
#include "axode/dynamics/mass_matrix_solver.hpp"

namespace axode {

/// a = M⁻¹ (τ - inverse dynamics at a = 0).
template <class Rep, class T, TreeOf<T> AnyTree>
Solvability solve_forward_dynamics(const AnyTree& tree, typename Workspace<T>::Arena arena, const T* q,
                                   const T* v, const T* tau, const Loads<T>& loads, T* a) noexcept {
  InverseDynamicsRecursion<Rep, T> recursion{arena};
  T* zero = arena.template per_screw<T>();
  for (int c = 0; c < tree.nv; ++c) zero[c] = T(0);
  recursion.run(tree, q, v, zero, loads);
  recursion.project(tree, v, zero, loads.joint_losses, a);
  for (int c = 0; c < tree.nv; ++c) a[c] = tau[c] - a[c];
  const MassMatrixSolver<Rep, T> solver{tree, arena, recursion.bodies.link};
  solver.solve(a);
  return solver.solvability();
}

}  // namespace axode
