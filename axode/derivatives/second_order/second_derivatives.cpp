#include "axode/derivatives/second_order/second_derivatives.hpp"

#include <array>

#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/derivatives/second_order/tensors.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
void inverse_dynamics_second_derivatives(
    const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
    const std::type_identity_t<InverseDynamicsSecondDerivatives<T>>& second) {
  Arena arena = checked<"inverse_dynamics_second_derivatives">(model, workspace, q, v, a, second.qq,
                                                               second.qv, second.vv, second.aq);
  SecondOrderTensors<T> tensors(arena);
  tensors.run(model.tree<T>(), q.data(), v.data(), a.data(),
              {second.qq.data(), second.qv.data(), second.vv.data(), second.aq.data()});
}

template <class T>
Solvability forward_dynamics_second_derivatives(
    const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
    const std::type_identity_t<ForwardDynamicsSecondDerivatives<T>>& second) {
  Arena arena = checked<"forward_dynamics_second_derivatives">(model, workspace, q, v, tau, second.qq,
                                                               second.qv, second.vv, second.tauq);
  const int nv = model.nv();
  const std::array tensors{second.qq, second.qv, second.vv, second.tauq};
  HessiansOfAccelerations<T> hessians(arena);
  T* const w = hessians.w;
  const std::ptrdiff_t entries = static_cast<std::ptrdiff_t>(nv) * nv;
  Solvability verdict;
  for (int i = 0; i < nv; ++i) {  // part i of each tensor is the Hessian of a_i
    for (int c = 0; c < nv; ++c) w[c] = T(c == i);
    const auto row = [&](std::size_t k) { return tensors[k].data() + i * entries; };
    const Solvability found = hessians.one.run(model.tree<T>(), q.data(), v.data(), tau.data(), w, {},
                                               {row(0), row(1), row(2), row(3)});
    if (verdict.ok()) verdict = found;
  }
  return solved(verdict, {second.qq, second.qv, second.vv, second.tauq});
}

template AXODE_ENTRY decltype(inverse_dynamics_second_derivatives<AXODE_T>)
    inverse_dynamics_second_derivatives<AXODE_T>;
template AXODE_ENTRY decltype(forward_dynamics_second_derivatives<AXODE_T>)
    forward_dynamics_second_derivatives<AXODE_T>;

}  // namespace axode
