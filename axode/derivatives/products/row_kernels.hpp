#pragma once
#include <algorithm>

#include "axode/derivatives/displacement/first_order.hpp"
#include "axode/derivatives/products/inverse_dynamics_products.hpp"
#include "axode/derivatives/second_order/forward_second_order.hpp"
#include "axode/fast/inverse_dynamics.hpp"
#include "axode/table/functions.hpp"

/// Kernels that compute the functions of the table axode/table/functions.hpp, for states in SIMD lanes and
/// for tapes (recorded operations from which code is generated). run(tree, x, out) reads the inputs x and
/// writes the results one after the other. Loads and losses are ignored.
///
/// The template parameter By is the algorithm for accelerations, on the scalar By::T, with the mass matrix M
/// and the bias forces h:
///   accelerate(tree, q, v, tau, a) a = M⁻¹ (τ - h); must be called before the other functions
///   solve_one(tree, x)             x := M⁻¹ x
///   solve(tree, X)                 X := M⁻¹ X for an nv × nv matrix that is stored row by row
///   inverse(tree, X)               X := M⁻¹
namespace axode::catalog {

template <Id id, class By> struct RowKernel;
template <Id id, class By>
concept HasRowKernel = requires {
  sizeof(RowKernel<id, By>);
};

template <class By> struct RowKernel<Id("inverse_dynamics"), By> {
  using T = typename By::T;
  FastInverseDynamics<Plain<T>, T> recursion;
  explicit RowKernel(Arena& arena) : recursion(arena) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* tau) {
    for (int c = 0; c < tree->nv; ++c) tau[c] = T(tree.armature[c]) * x[Input::a][c];
    recursion.forward(tree, x[Input::q], x[Input::v], x[Input::a], cast<T>(tree.g));
    recursion.backward(tree, tau);
  }
};
template <class By> struct RowKernel<Id("inverse_dynamics_derivatives"), By> {
  using T = typename By::T;
  FirstOrder<T> first_order;
  explicit RowKernel(Arena& arena) : first_order(arena) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* out) {
    write(tree, x, x[Input::a], out);
  }
  template <class Real> void write(const Tree<Real>& tree, const Read<T>& x, const T* a, T* out) {
    const std::ptrdiff_t entries = std::ptrdiff_t(tree->nv) * tree->nv;
    first_order.run(tree, x[Input::q], x[Input::v], a, {});
    first_order.write(tree, {}, out, out + entries, out + 2 * entries);
  }
};
template <class By> struct RowKernel<Id("inverse_dynamics_jvp"), By> {
  using T = typename By::T;
  InverseDynamicsJvp<T> jvp;
  explicit RowKernel(Arena& arena) : jvp(arena) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* dtau) {
    jvp.run(tree, x[Input::q], x[Input::v], x[Input::a], x[Input::dq], x[Input::dv], x[Input::da], {}, dtau);
  }
};
template <class By> struct RowKernel<Id("inverse_dynamics_vjp"), By> {
  using T = typename By::T;
  InverseDynamicsVjp<T> vjp;
  explicit RowKernel(Arena& arena) : vjp(arena) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* gradient) {
    vjp.run(tree, x[Input::q], x[Input::v], x[Input::a], x[Input::weights], {});
    for (const T* const part : {vjp.by_q, vjp.by_v, vjp.by_a})
      gradient = std::copy_n(part, tree->nv, gradient);
  }
};
template <class By> struct RowKernel<Id("inverse_dynamics_hessian"), By> {
  using T = typename By::T;
  SecondOrder<T> second;
  explicit RowKernel(Arena& arena) : second(arena) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* hessian) {
    std::fill_n(hessian, 4 * std::ptrdiff_t(tree->nv) * tree->nv, T(0));
    second.run(tree, x[Input::q], x[Input::v], x[Input::a], x[Input::weights], {});
    second.add_to(*tree.operator->(), false, blocks(tree->nv, hessian));
  }
  static HessianBlocks<T> blocks(std::ptrdiff_t nv, T* hessian) {
    const std::ptrdiff_t entries = nv * nv;
    return {hessian, hessian + entries, hessian + 2 * entries, hessian + 3 * entries};
  }
};

template <class By> struct RowKernel<Id("forward_dynamics"), By> {
  using T = typename By::T;
  By by;
  explicit RowKernel(Arena& arena) : by(arena) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* a) {
    by.accelerate(tree, x[Input::q], x[Input::v], x[Input::tau], a);
  }
};
/// Computes ∂a/∂q, ∂a/∂v and ∂a/∂τ of forward dynamics: ∂a/∂x = -M⁻¹ ∂τ/∂x for x = q and v, with the mass
/// matrix M and ∂τ/∂x of inverse dynamics at the accelerations a, and ∂a/∂τ = M⁻¹.
template <class By> struct RowKernel<Id("forward_dynamics_derivatives"), By> {
  using T = typename By::T;
  RowKernel<Id("inverse_dynamics_derivatives"), By> inverse;
  By by;
  T* a;
  explicit RowKernel(Arena& arena) : inverse(arena), by(arena), a(arena.per_velocity<T>()) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* out) {
    const std::ptrdiff_t entries = std::ptrdiff_t(tree->nv) * tree->nv;
    by.accelerate(tree, x[Input::q], x[Input::v], x[Input::tau], a);
    inverse.write(tree, x, a, out);
    for (std::ptrdiff_t k = 0; k < 2 * entries; ++k) out[k] = -out[k];
    by.solve(tree, out);
    by.solve(tree, out + entries);
    by.inverse(tree, out + 2 * entries);
  }
};
/// Computes the change da of the accelerations of forward dynamics along (dq, dv, dτ): da = M⁻¹ (dτ - x),
/// with the mass matrix M and the change x of the forces of inverse dynamics along (dq, dv) at constant
/// accelerations.
template <class By> struct RowKernel<Id("forward_dynamics_jvp"), By> {
  using T = typename By::T;
  InverseDynamicsJvp<T> jvp;
  By by;
  T *a, *zero;
  explicit RowKernel(Arena& arena)
      : jvp(arena), by(arena), a(arena.per_velocity<T>()), zero(arena.per_velocity<T>()) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* da) {
    by.accelerate(tree, x[Input::q], x[Input::v], x[Input::tau], a);
    std::fill_n(zero, tree->nv, T(0));
    jvp.run(tree, x[Input::q], x[Input::v], a, x[Input::dq], x[Input::dv], zero, {}, da);
    for (int c = 0; c < tree->nv; ++c) da[c] = x[Input::dtau][c] - da[c];
    by.solve_one(tree, da);
  }
};
/// Computes the gradients of w·a, the sum of the accelerations a of forward dynamics with weights w. The
/// gradient by τ is μ = M⁻¹ w with the mass matrix M. The gradients by q and v equal the gradients of -μ·τ of
/// inverse dynamics at the accelerations a.
template <class By> struct RowKernel<Id("forward_dynamics_vjp"), By> {
  using T = typename By::T;
  InverseDynamicsVjp<T> vjp;
  By by;
  T* a;
  explicit RowKernel(Arena& arena) : vjp(arena), by(arena), a(arena.per_velocity<T>()) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* gradient) {
    T* const mu = gradient + 2 * tree->nv;
    by.accelerate(tree, x[Input::q], x[Input::v], x[Input::tau], a);
    std::copy_n(x[Input::weights], tree->nv, mu);
    by.solve_one(tree, mu);
    vjp.run(tree, x[Input::q], x[Input::v], a, mu, {});
    for (int c = 0; c < tree->nv; ++c) {
      gradient[c] = -vjp.by_q[c];
      gradient[tree->nv + c] = -vjp.by_v[c];
    }
  }
};
template <class By> struct RowKernel<Id("forward_dynamics_hessian"), By> {
  using T = typename By::T;
  SecondOrder<T> second;
  By by;
  T *a, *mu;
  explicit RowKernel(Arena& arena)
      : second(arena), by(arena), a(arena.per_velocity<T>()), mu(arena.per_velocity<T>()) {}
  template <class Real> void run(const Tree<Real>& tree, const Read<T>& x, T* hessian) {
    by.accelerate(tree, x[Input::q], x[Input::v], x[Input::tau], a);
    for (int c = 0; c < tree->nv; ++c) mu[c] = -x[Input::weights][c];
    by.solve_one(tree, mu);
    second.run(tree, x[Input::q], x[Input::v], a, mu, {});
    accelerations_from(second, tree, {},
                       RowKernel<Id("inverse_dynamics_hessian"), By>::blocks(tree->nv, hessian),
                       [&](T* matrix) { by.solve(tree, matrix); });
  }
};

}  // namespace axode::catalog
