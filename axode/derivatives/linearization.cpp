#include "axode/derivatives/linearization.hpp"

#include <algorithm>

#include "axode/derivatives/displacement/velocity_bracket.hpp"
#include "axode/derivatives/forward_dynamics_derivatives.hpp"
#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

/// Adds the product x y of two n × n matrices to the n × n matrix `out`. Zeros of y are skipped.
template <class T>
void add_product(std::span<const T> x, std::span<const T> y, std::size_t n, std::span<T> out) {
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t k = 0; k < n; ++k)
      if (const T y_jk = y[j * n + k]; y_jk != T(0))
        for (std::size_t i = 0; i < n; ++i) out[i * n + k] += x[i * n + j] * y_jk;
}

}  // namespace

template <class T>
Solvability linearize(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
                      const std::type_identity_t<Linearization<T>>& linear,
                      const std::type_identity_t<Loads<T>>& loads) {
  catalog::check_counts<"linearize">(model);
  return linearize_without_drives(model, workspace, q, v, tau, linear, loads);
}

template <class T>
Solvability linearize_without_drives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     Numbers<T> tau, const std::type_identity_t<Linearization<T>>& linear,
                                     const std::type_identity_t<Loads<T>>& loads) {
  const auto& [A, B] = linear;
  const std::size_t n = static_cast<std::size_t>(model.nv()), width = 2 * n;
  check_size("linear.A", A.size(), width * width, "2nv * 2nv");
  check_size("linear.B", B.size(), width * n, "2nv * nv");
  check_separate("linear.B", B, "linear.A", A);
  const bool sprung = !model.springs().empty();
  const auto check_apart = [&](const char* name, std::span<const T> x) {
    check_separate("linear.A", linear.A, name, x);
    check_separate("linear.B", linear.B, name, x);
  };
  check_apart("v", v);
  if (sprung) {
    check_apart("q", q);
    check_apart("tau", tau);
  }

  // The upper half of A is used as scratch memory until the lower half is complete.
  const std::span<T> upper = A.first(width * n), lower = A.last(width * n);
  const std::span<T> da_dq = upper.first(n * n), da_dv = upper.last(n * n);
  const std::span<T> da_dtau = B.last(n * n), forces_dq = lower.first(n * n), forces_dv = lower.last(n * n);
  Numbers<T> forces = tau;
  if (sprung) {
    check_size("tau", tau.size(), n, "nv");
    const std::span<T> total = B.first(n);
    std::ranges::copy(tau, total.begin());
    add_spring_forces(model, workspace, q, v, total);
    forces = total;
  }
  const Solvability verdict =
      forward_dynamics_derivatives(model, workspace, q, v, forces, {da_dq, da_dv, da_dtau}, loads);
  if (verdict.ok() && sprung) {
    spring_force_derivatives(model, workspace, q, v, {forces_dq, forces_dv});
    add_product<T>(da_dtau, forces_dq, n, da_dq);
    add_product<T>(da_dtau, forces_dv, n, da_dv);
  }
  if (!verdict.ok()) return solved(verdict, {A, B});
  for (std::size_t i = 0; i < n; ++i) {
    std::ranges::copy(da_dq.subspan(i * n, n), &lower[i * width]);
    std::ranges::copy(da_dv.subspan(i * n, n), &lower[i * width + n]);
  }
  std::ranges::fill(upper, T(0));
  std::ranges::fill(B.first(n * n), T(0));
  for (std::size_t i = 0; i < n; ++i) upper[i * width + n + i] = T(1);
  subtract_ad(model.tree<T>(), v.data(), static_cast<std::ptrdiff_t>(width), upper.data());
  return solved(verdict, {A, B});
}

template AXODE_ENTRY decltype(linearize<AXODE_T>) linearize<AXODE_T>;
template AXODE_ENTRY decltype(linearize_without_drives<AXODE_T>) linearize_without_drives<AXODE_T>;

}  // namespace axode
