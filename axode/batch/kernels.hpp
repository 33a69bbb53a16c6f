#pragma once
#include <cstddef>

#include "axode/model/arena.hpp"
#include "axode/model/tree.hpp"

namespace axode::batch {

/// The algorithms for one instruction set. Each takes exactly `lanes` states; the arena has bytes(tree). forward_dynamics and inverse_mass_matrix return a bit for each lane whose mass matrix may be
/// singular. Models without coupled joints; inverse_dynamics and its derivatives, poses and joint_screws take all.
template <class S> struct Kernels {
  int lanes;
  std::size_t (*bytes)(const Tree<S>&);
  void (*inverse_dynamics)(const Tree<S>&, Arena arena, const S* q, const S* v, const S* a, S* tau) noexcept;
  unsigned (*forward_dynamics)(const Tree<S>&, Arena arena, const S* q, const S* v, const S* tau,
                               S* a) noexcept;
  void (*mass_matrix)(const Tree<S>&, Arena arena, const S* q, S* M) noexcept;
  unsigned (*inverse_mass_matrix)(const Tree<S>&, Arena arena, const S* q, S* M_inverse) noexcept;
  void (*poses)(const Tree<S>&, Arena arena, const S* q, SE3<S>* C) noexcept;
  void (*joint_screws)(const Tree<S>&, Arena arena, const S* q, Twist<Spatial, S>* J) noexcept;
  // Of derivatives all results of a state lie one behind the other. Those of forward dynamics return bits as it does.
  void (*inverse_dynamics_derivatives)(const Tree<S>&, Arena arena, const S* q, const S* v, const S* a,
                                       S* dtau) noexcept;
  unsigned (*forward_dynamics_derivatives)(const Tree<S>&, Arena arena, const S* q, const S* v, const S* tau,
                                           S* da) noexcept;
  void (*inverse_dynamics_jvp)(const Tree<S>&, Arena arena, const S* q, const S* v, const S* a, const S* dq,
                               const S* dv, const S* da, S* dtau) noexcept;
  unsigned (*forward_dynamics_jvp)(const Tree<S>&, Arena arena, const S* q, const S* v, const S* tau,
                                   const S* dq, const S* dv, const S* dtau, S* da) noexcept;
  void (*inverse_dynamics_vjp)(const Tree<S>&, Arena arena, const S* q, const S* v, const S* a, const S* w,
                               S* gradient) noexcept;
  unsigned (*forward_dynamics_vjp)(const Tree<S>&, Arena arena, const S* q, const S* v, const S* tau,
                                   const S* w, S* gradient) noexcept;
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

}  // namespace axode::batch
