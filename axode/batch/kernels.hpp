#pragma once
#include <array>
#include <cstddef>

#include "axode/batch/compiled_dynamics.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/model/arena.hpp"
#include "axode/model/tree.hpp"
#include "axode/table/functions.hpp"

namespace axode::batch {

/// A row of the table on exactly `lanes` states. Its arena has bytes(tree); the numbers of the states lie one
/// behind the other, and so do their results. It returns a bit for each lane whose mass matrix may be
/// singular.
template <class S> struct LaneKernel {
  std::size_t (*bytes)(const Tree<S>&) = nullptr;
  unsigned (*call)(const Tree<S>&, Arena, const catalog::Read<S>& given, S* out) noexcept = nullptr;
  bool takes_coupled_joints = false;
};

/// A drive of axode/integration/drives.hpp, the same for all motions. With x from q ⊕ x = q_d, where it
/// tracks,
///   y = kp x + kd (v_d - v) + w,   τ = y within the limits, or τ = ID(q, v, y) where it computes.
template <class S> struct ControlLaw {
  bool tracks, computes;
  const S *kp, *kd;  ///< nv each
  const S* limit;    ///< nv, or none
  const S* rows;     ///< q_d (nq), v_d (nv) and w (nv) for each stage, from that of the first step on
};

/// Memory for as many states as there are lanes, one behind the other, in which it is called.
template <class S> struct CompiledCall {
  const CompiledDynamics<S>* dynamics;
  S *q, *v, *tau, *a, *scratch;
  unsigned char* maybe_singular;
};

/// Motions of K steps, at most as many as there are lanes: the states of one lie behind each other, and so do
/// its forces.
template <class S> struct Motions {
  const S* tau;              ///< K nv for each; or
  const ControlLaw<S>* law;  ///< that of their drive
  S *q, *v;                  ///< (K + 1) nq and nv for each
  std::ptrdiff_t K, count;
  double step;
  bool damped;                      ///< whether the joints' damping acts besides
  const CompiledCall<S>* compiled;  ///< in the place of the library's forward dynamics; or none
};
/// Explicit methods on motions in lanes. What make() returns has memory of its own, and goes with remove().
template <class S> struct RolloutKernel {
  void* (*make)(const Tree<S>&, const Tableau&);
  /// Steps k to end - 1, from the states k. A bit for each lane whose mass matrix may be singular.
  unsigned (*run)(void*, const Motions<S>&, std::ptrdiff_t k, std::ptrdiff_t end) noexcept;
  void (*remove)(void*) noexcept;
};

/// The algorithms for one instruction set: the rows that have lanes, in the order of the table. Rollouts take
/// models without coupled joints, or compiled dynamics.
template <class S> struct Kernels {
  int lanes;
  std::array<LaneKernel<S>, catalog::functions_of_state.size()> rows;
  RolloutKernel<S> rollout;
};

/// Instruction sets.
struct sse2;
struct avx2;
struct avx512;

/// The kernels for one of them; S is double or float.
template <class InstructionSet, class S> const Kernels<S>& kernels();
template <> const Kernels<double>& kernels<sse2, double>();
template <> const Kernels<float>& kernels<sse2, float>();
template <> const Kernels<double>& kernels<avx2, double>();
template <> const Kernels<float>& kernels<avx2, float>();
template <> const Kernels<double>& kernels<avx512, double>();
template <> const Kernels<float>& kernels<avx512, float>();
/// Those for the best instruction set that this processor has.
template <class S> const Kernels<S>& best_kernels();

}  // namespace axode::batch
