#pragma once
#include "axode/derivatives/accelerations.hpp"
#include "axode/derivatives/forward_second_order.hpp"
#include "axode/derivatives/inverse_dynamics_products.hpp"

/// What the functions of this floor take of a workspace, besides the kernels themselves.
namespace axode {

template <class T> struct ForwardJvp {
  AccelerationsAndColumns<T> forward;
  InverseDynamicsJvp<T> jvp;
  T *zero, *x;

  explicit ForwardJvp(Arena& arena)
      : forward(arena), jvp(arena), zero(arena.per_velocity<T>()), x(arena.per_velocity<T>()) {}
};
template <class T> struct ForwardVjp {
  AccelerationsAndColumns<T> forward;
  InverseDynamicsVjp<T> vjp;
  T* mu;

  explicit ForwardVjp(Arena& arena) : forward(arena), vjp(arena), mu(arena.per_velocity<T>()) {}
};

/// A Hessian for each component.
template <class T> struct HessiansOfAccelerations {
  ForwardSecondOrder<T> one;
  T* w;

  explicit HessiansOfAccelerations(Arena& arena) : one(arena), w(arena.per_velocity<T>()) {}
};

}  // namespace axode
