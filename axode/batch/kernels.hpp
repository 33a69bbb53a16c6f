#pragma once
#include <array>
#include <cstddef>

#include "axode/batch/compiled_dynamics.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/model/arena.hpp"
#include "axode/model/tree.hpp"
#include "axode/table/functions.hpp"

namespace axode::batch {

/// Computes a function of the table axode/table/functions.hpp for as many states at once as there are SIMD
/// lanes. call() needs scratch memory of bytes(tree) bytes, takes one state after the other, each with
/// contiguous numbers, and returns a bit for each state whose mass matrix may be singular.
template <class S> struct LaneKernel {
  std::size_t (*bytes)(const Tree<S>&) = nullptr;
  unsigned (*call)(const Tree<S>&, Arena, const catalog::Read<S>& given, S* out) noexcept = nullptr;
  bool takes_coupled_joints = false;
};

/// The law of a drive that several motions of a batch call share. With a reference motion (q_d, v_d), the
/// gains kp and kd and a given w, it computes
///
///     y = kp x + kd (v_d - v) + w,    q ⊕ x = q_d,
///
/// and without a reference motion y = w. If `computes` is set, w are the accelerations of the reference
/// motion, and the drive forces are those of inverse dynamics at q, v and the accelerations y. Otherwise w
/// are feedforward forces, and the drive forces are y, clipped to between -limit and limit.
template <class S> struct ControlLaw {
  bool tracks, computes;
  const S *kp, *kd;  ///< gains, nv numbers each
  const S* limit;    ///< largest forces, nv numbers, or null if there is no limit
  const S* rows;     ///< q_d (nq), v_d (nv) and w (nv) for each stage, beginning with those of the first step
};

/// Forward dynamics that was generated and compiled for one model, with memory for the arguments and results
/// of as many states as there are SIMD lanes. In each array the numbers of one state are contiguous.
template <class S> struct CompiledCall {
  const CompiledDynamics<S>* dynamics;
  S *q, *v, *tau, *a, *scratch;
  unsigned char* maybe_singular;
};

/// Data of `count` motions (at most one for each SIMD lane) of K steps that are integrated at once. The
/// states of one motion are contiguous, and so are its forces.
template <class S> struct Motions {
  const S* tau;              ///< forces, K nv for each motion; not used if there is a control law
  const ControlLaw<S>* law;  ///< the control law, or null if forces are given
  S *q, *v;                  ///< states, (K + 1) nq and (K + 1) nv for each motion
  std::ptrdiff_t K, count;
  double step;
  bool damped;                      ///< whether damping in the joints acts
  const CompiledCall<S>* compiled;  ///< replaces the library's forward dynamics unless it is null
};
/// Integrates several motions at once, one in each SIMD lane, by explicit Runge-Kutta methods. make()
/// allocates an integrator, and remove() deletes it.
template <class S> struct RolloutKernel {
  void* (*make)(const Tree<S>&, const Tableau&);
  /// Computes steps k to end - 1 of all motions. The states with index k of the motions must be given.
  /// Returns a bit for each motion whose mass matrix may be singular.
  unsigned (*run)(void*, const Motions<S>&, std::ptrdiff_t k, std::ptrdiff_t end) noexcept;
  void (*remove)(void*) noexcept;
};

/// The kernels for one instruction set of the processor. `rows` has a kernel for each function of the table
/// axode/table/functions.hpp, in its order, or null for a function that cannot be computed in SIMD lanes. The
/// kernels of rollouts compute trees without coupled joints; for a model with coupled joints they call the
/// functions that code generation has written and compiled for this model.
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
