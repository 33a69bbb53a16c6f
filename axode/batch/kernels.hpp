#pragma once
#include <cstddef>

#include "axode/model/tree.hpp"

namespace axode::batch {

/// The algorithms for one instruction set. Each takes exactly `lanes` states; memory has bytes(tree), aligned
/// to 64. forward_dynamics and inverse_mass_matrix return a bit for each lane whose mass matrix may be
/// singular. Models without coupled joints; inverse_dynamics, poses and joint_screws take all.
template <class S> struct Kernels {
  int lanes;
  std::size_t (*bytes)(const Tree<S>&);
  void (*inverse_dynamics)(const Tree<S>&, std::byte* memory, const S* q, const S* v, const S* a,
                           S* tau) noexcept;
  unsigned (*forward_dynamics)(const Tree<S>&, std::byte* memory, const S* q, const S* v, const S* tau,
                               S* a) noexcept;
  void (*mass_matrix)(const Tree<S>&, std::byte* memory, const S* q, S* M) noexcept;
  unsigned (*inverse_mass_matrix)(const Tree<S>&, std::byte* memory, const S* q, S* M_inverse) noexcept;
  void (*poses)(const Tree<S>&, std::byte* memory, const S* q, SE3<S>* C) noexcept;
  void (*joint_screws)(const Tree<S>&, std::byte* memory, const S* q, Twist<Spatial, S>* J) noexcept;
};

const Kernels<double>& kernels_sse2(double);
const Kernels<float>& kernels_sse2(float);
const Kernels<double>& kernels_avx2(double);
const Kernels<float>& kernels_avx2(float);
const Kernels<double>& kernels_avx512(double);
const Kernels<float>& kernels_avx512(float);

}  // namespace axode::batch
