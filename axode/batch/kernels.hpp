#pragma once
#include <array>
#include <cstddef>

#include "axode/batch/compiled_dynamics.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/model/arena.hpp"
#include "axode/model/tree.hpp"
#include "axode/table/functions.hpp"

namespace axode::batch {

/// The kernel of a row of the table, for exactly `lanes` states at once. It needs an arena of bytes(tree)
/// bytes. Arguments and results of the states are contiguous. Returns a bit for each lane whose mass matrix
/// may be singular.
template <class S> struct LaneKernel {
  std::size_t (*bytes)(const Tree<S>&) = nullptr;
  unsigned (*call)(const Tree<S>&, Arena, const catalog::Read<S>& given, S* out) noexcept = nullptr;
  bool takes_coupled_joints = false;
};

/// A drive of axode/integration/drives.hpp that all motions share. If it tracks, x is the solution of q ⊕ x =
/// q_d, and
///   y = kp x + kd (v_d - v) + w,
/// otherwise y = w. τ is ID(q, v, y) if it computes torques, otherwise y within the limits.
template <class S> struct ControlLaw {
  bool tracks, computes;
  const S *kp, *kd;  ///< nv each
  const S* limit;    ///< nv, or null
  const S* rows;     ///< q_d (nq), v_d (nv) and w (nv) for each stage, beginning with those of the first step
};

/// Compiled dynamics with memory for as many contiguous states as there are lanes.
template <class S> struct CompiledCall {
  const CompiledDynamics<S>* dynamics;
  S *q, *v, *tau, *a, *scratch;
  unsigned char* maybe_singular;
};

/// Arguments and results of RolloutKernel::run: at most as many motions of K steps as there are lanes. The
/// states of one motion are contiguous, and so are its forces.
template <class S> struct Motions {
  const S* tau;              ///< forces, K nv for each motion; not used if there is a law
  const ControlLaw<S>* law;  ///< the law of the drive, or null
  S *q, *v;                  ///< states, (K + 1) nq and (K + 1) nv for each motion
  std::ptrdiff_t K, count;
  double step;
  bool damped;                      ///< whether damping in the joints acts
  const CompiledCall<S>* compiled;  ///< replaces the library's forward dynamics unless it is null
};
/// Explicit integration methods on motions in lanes. make() allocates an integrator, and remove() deletes it.
template <class S> struct RolloutKernel {
  void* (*make)(const Tree<S>&, const Tableau&);
  /// Computes steps k to end - 1, from the states k. Returns a bit for each lane whose mass matrix may be
  /// singular.
  unsigned (*run)(void*, const Motions<S>&, std::ptrdiff_t k, std::ptrdiff_t end) noexcept;
  void (*remove)(void*) noexcept;
};

/// The kernels of one instruction set: those of the rows that have lanes, in the order of the table, and the
/// rollouts. Rollouts take a model without coupled joints, or compiled dynamics.
template <class S> struct Kernels {
  int lanes;
  std::array<LaneKernel<S>, catalog::functions_of_state.size()> rows;
  RolloutKernel<S> rollout;
};

/// The kernels of the chosen instruction set; S is double or float.
template <class S> const Kernels<S>& kernels();
template <> const Kernels<double>& kernels<double>();
template <> const Kernels<float>& kernels<float>();

}  // namespace axode::batch
