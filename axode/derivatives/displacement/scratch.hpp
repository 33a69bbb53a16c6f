#pragma once
#include <algorithm>
#include <span>

#include "axode/derivatives/displacement/accelerations.hpp"
#include "axode/derivatives/displacement/geometry.hpp"
#include "axode/derivatives/displacement/momentum_first_order.hpp"
#include "axode/derivatives/products/inverse_dynamics_products.hpp"
#include "axode/derivatives/second_order/forward_second_order.hpp"
#include "axode/derivatives/second_order/second_order_recursions.hpp"
#include "axode/kinematics/path.hpp"

/// Scratch memory of the functions in axode/derivatives, in addition to that of their kernels.
namespace axode {

template <class T> struct ForwardJvp {
  AccelerationsAndColumns<T> forward;
  InverseDynamicsJvp<T> jvp;
  T *zero, *x;

  explicit ForwardJvp(Arena& arena)
      : forward(arena), jvp(arena), zero(arena.per_velocity<T>()), x(arena.per_velocity<T>()) {}

  /// Computes the change of the accelerations of forward dynamics for the changes dq, dv and dtau of its
  /// arguments: M⁻¹ (dtau - ∂τ/∂q dq - ∂τ/∂v dv), with the mass matrix M and the derivatives of inverse
  /// dynamics at these accelerations (D1.24).
  Solvability run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const T* dq, const T* dv,
                  const T* dtau, const Loads<T>& loads) noexcept {
    const Solvability verdict = forward.run(tree, q, v, tau, loads);
    if (!verdict.ok()) return verdict;
    std::fill_n(zero, tree->nv, T(0));
    jvp.run(tree, q, v, forward.a, dq, dv, zero, loads, x);
    for (int c = 0; c < tree->nv; ++c) x[c] = dtau[c] - x[c];
    forward.solve_one(tree, x);
    return verdict;
  }
};
template <class T> struct ForwardVjp {
  AccelerationsAndColumns<T> forward;
  InverseDynamicsVjp<T> vjp;
  T* mu;

  explicit ForwardVjp(Arena& arena) : forward(arena), vjp(arena), mu(arena.per_velocity<T>()) {}

  Solvability run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const T* w,
                  const Loads<T>& loads) noexcept {
    const Solvability verdict = forward.run(tree, q, v, tau, loads);
    if (verdict.ok()) compute_gradient(tree, q, v, w, loads);
    return verdict;
  }
  /// Computes the gradients, by q and v, of w·a with constant weights w for the accelerations a of forward
  /// dynamics, which must have been computed before. With the mass matrix M and μ = M⁻¹ w they are the
  /// gradients of -μ·τ of inverse dynamics at constant accelerations a.
  void compute_gradient(const Tree<T>& tree, const T* q, const T* v, const T* w,
                        const Loads<T>& loads) noexcept {
    std::copy_n(w, tree->nv, mu);
    forward.solve_one(tree, mu);
    vjp.run(tree, q, v, forward.a, mu, loads);
    for (int c = 0; c < tree->nv; ++c) {
      vjp.by_q[c] = -vjp.by_q[c];
      vjp.by_v[c] = -vjp.by_v[c];
    }
  }
};

/// Computes the derivatives of one term of the equations of motion by setting all other terms to 0.
template <class T> struct TermDerivatives {
  FirstOrder<T> state;
  T* zero;

  explicit TermDerivatives(Arena& arena) : state(arena), zero(arena.per_velocity<T>()) {}

  /// Computes the derivatives dq by q and dv by v of the forces of inverse dynamics at accelerations 0, under
  /// gravity g and the loads. A null v means velocities 0; a null dq or dv is not computed.
  void run(const Tree<T>& tree, const T* q, const T* v, const Loads<T>& loads, const Vec3<T>& g, T* dq,
           T* dv) noexcept {
    std::fill_n(zero, tree->nv, T(0));
    state.run(tree, q, v ? v : zero, zero, loads, g);
    const std::ptrdiff_t nv = tree->nv;
    const auto add_to = [nv](T* matrix) {
      if (matrix) std::fill_n(matrix, nv * nv, T(0));
      return [matrix, nv](std::ptrdiff_t r, std::ptrdiff_t c, const T& x) {
        if (matrix) matrix[r * nv + c] += x;
      };
    };
    state.each_entry(tree, loads, add_to(dq), add_to(dv));
  }
};
template <class T> struct EnergyGradient {
  InverseDynamicsVjp<T> vjp;
  T* zero;

  explicit EnergyGradient(Arena& arena) : vjp(arena), zero(arena.per_velocity<T>()) {}
};

/// The columns of the body-fixed Jacobian of a place (a frame on a body): the screws of all joints between
/// the ground and the place, beginning with the joint of the body that carries the place. They are about the
/// origin of the place and in its axes.
template <class T> struct CarryingScrews {
  struct Column {
    int j, c;  ///< indices of body and velocity
    Twist<BodyFixed, T> J;
  };
  Column* column;
  int count = 0;

  explicit CarryingScrews(Arena& arena) : column(arena.per_screw<Column>()) {}
  void run(const Tree<T>& tree, const T* q, const Place<T>& place) noexcept {
    each_body_fixed_column(tree, q, place, [&](int j, int c, const Screw<T>& J) {
      column[count++] = {j, c, {J.w, J.v}};
    });
  }
};

/// The joint screws that move the two ends of a spring relative to each other, or those of a straight segment
/// of a spring over several points. by_q and rate_by_q are the derivatives, by the joint coordinates q, of
/// the spring's coordinate (its length, for example) and of the time derivative of this coordinate.
template <class T> struct SpringColumns {
  struct Column {
    int end, body, c;  ///< index of the end, of the body and of the velocity
    Screw<T> X;
  };
  Column* column;
  int count = 0;
  T *by_q, *rate_by_q;
  int* velocities;  ///< indices of velocities on the paths, each once
  int n_velocities = 0;

  explicit SpringColumns(Arena& arena)
      : column(arena.per_screw<Column>()),
        by_q(arena.per_velocity<T>()),
        rate_by_q(arena.per_velocity<T>()),
        velocities(arena.per_velocity<int>()),
        listed_(arena.per_velocity<char>()),
        nv_(arena.topology().nv) {}

  std::span<const Column> all() const { return {column, static_cast<std::size_t>(count)}; }
  /// Forgets the columns and derivatives of the last spring.
  void clear() noexcept {
    count = n_velocities = 0;
    std::fill_n(listed_, nv_, char(0));
  }
  /// Adds x to the derivative of the spring coordinate, and dx to that of its rate, by the joint coordinate
  /// of velocity c.
  void add(int c, const T& x, const T& dx) noexcept {
    if (!listed_[c]) {
      listed_[c] = 1;
      velocities[n_velocities++] = c;
      by_q[c] = rate_by_q[c] = T(0);
    }
    by_q[c] += x;
    rate_by_q[c] += dx;
  }

 private:
  char* listed_;
  int nv_;
};

/// Memory for the Hessians of the components of the accelerations, which are computed one after the other.
template <class T> struct HessiansOfAccelerations {
  ForwardSecondOrder<T> one;
  T* w;

  explicit HessiansOfAccelerations(Arena& arena) : one(arena), w(arena.per_velocity<T>()) {}
};

}  // namespace axode
