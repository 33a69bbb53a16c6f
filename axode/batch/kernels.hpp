#pragma once
#include <cstddef>

#include "axode/batch/compiled_dynamics.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/model/arena.hpp"
#include "axode/model/tree.hpp"

namespace axode::batch {

/// One algorithm on exactly `lanes` states; its arena has bytes(tree).
template <class S, class Call> struct Kernel {
  std::size_t (*bytes)(const Tree<S>&);
  Call* call;
};

/// A drive of axode/integration/drives.hpp, the same for all motions. With x from q ⊕ x = q_d, where it tracks,
///   y = kp x + kd (v_d - v) + w,   τ = y within the limits, or τ = ID(q, v, y) where it computes.
template <class S> struct Law {
  bool tracks, computes;
  const S *kp, *kd;  ///< nv each
  const S* limit;    ///< nv, or none
  const S* rows;     ///< q_d (nq), v_d (nv) and w (nv) for each stage, from that of the first step on
};

/// Memory for as many states as there are lanes, one behind the other, in which it is called.
template <class S> struct CompiledCall {
  const CompiledDynamics<S>* dynamics;
  S *q, *v, *tau, *a, *scratch;
  unsigned char* doubts;
};

/// Motions of K steps, at most as many as there are lanes: the states of one lie behind each other, and so do its forces.
template <class S> struct Motions {
  const S* tau;       ///< K nv for each; or
  const Law<S>* law;  ///< that of their drive
  S *q, *v;           ///< (K + 1) nq and nv for each
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

/// The algorithms for one instruction set. Those that solve for accelerations return a bit for each lane whose mass
/// matrix may be singular. Models without coupled joints; inverse_dynamics and its derivatives, poses, joint_screws and rollouts
/// by compiled dynamics take all.
template <class S> struct Kernels {
  int lanes;
  Kernel<S, void(const Tree<S>&, Arena, const S* q, const S* v, const S* a, S* tau) noexcept>
      inverse_dynamics;
  Kernel<S, unsigned(const Tree<S>&, Arena, const S* q, const S* v, const S* tau, S* a) noexcept>
      forward_dynamics;
  Kernel<S, void(const Tree<S>&, Arena, const S* q, S* M) noexcept> mass_matrix;
  Kernel<S, unsigned(const Tree<S>&, Arena, const S* q, S* M_inverse) noexcept> inverse_mass_matrix;
  Kernel<S, void(const Tree<S>&, Arena, const S* q, SE3<S>* C) noexcept> poses;
  Kernel<S, void(const Tree<S>&, Arena, const S* q, Twist<Spatial, S>* J) noexcept> joint_screws;
  // Of derivatives all results of a state lie one behind the other.
  Kernel<S, void(const Tree<S>&, Arena, const S* q, const S* v, const S* a, S* dtau) noexcept>
      inverse_dynamics_derivatives;
  Kernel<S, unsigned(const Tree<S>&, Arena, const S* q, const S* v, const S* tau, S* da) noexcept>
      forward_dynamics_derivatives;
  Kernel<S, void(const Tree<S>&, Arena, const S* q, const S* v, const S* a, const S* dq, const S* dv,
                 const S* da, S* dtau) noexcept>
      inverse_dynamics_jvp;
  Kernel<S, unsigned(const Tree<S>&, Arena, const S* q, const S* v, const S* tau, const S* dq, const S* dv,
                     const S* dtau, S* da) noexcept>
      forward_dynamics_jvp;
  Kernel<S, void(const Tree<S>&, Arena, const S* q, const S* v, const S* a, const S* w, S* gradient) noexcept>
      inverse_dynamics_vjp;
  Kernel<S, unsigned(const Tree<S>&, Arena, const S* q, const S* v, const S* tau, const S* w,
                     S* gradient) noexcept>
      forward_dynamics_vjp;
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
