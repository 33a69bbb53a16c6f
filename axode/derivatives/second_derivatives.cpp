#include "axode/derivatives/second_derivatives.hpp"

#include <array>

#include "axode/derivatives/scratch.hpp"
#include "axode/derivatives/tensors.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

template <class T>
void inverse_dynamics_second_derivatives(
    const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
    const std::type_identity_t<InverseDynamicsSecondDerivatives<T>>& second) {
  catalog::check_counts<"inverse_dynamics_second_derivatives">(model, workspace);
  check_state(model, workspace, q, v, a);
  check_results<T>(model, {{"second.qq", second.qq, 3},
                           {"second.qv", second.qv, 3},
                           {"second.vv", second.vv, 3},
                           {"second.aq", second.aq, 3}});
  Arena arena = workspace.arena(model.topology());
  SecondOrderTensors<T> tensors(arena);
  tensors.run(model.tree<T>(), q.data(), v.data(), a.data(),
              {second.qq.data(), second.qv.data(), second.vv.data(), second.aq.data()});
}

template <class T>
Solvability forward_dynamics_second_derivatives(
    const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
    const std::type_identity_t<ForwardDynamicsSecondDerivatives<T>>& second) {
  catalog::check_counts<"forward_dynamics_second_derivatives">(model, workspace);
  check_state(model, workspace, q, v);
  const int nv = model.nv();
  check_size("tau", tau.size(), static_cast<std::size_t>(nv), "nv");
  const std::array tensors{second.qq, second.qv, second.vv, second.tauq};
  const std::array names{"second.qq", "second.qv", "second.vv", "second.tauq"};
  check_results<T>(model, {{names[0], second.qq, 3},
                           {names[1], second.qv, 3},
                           {names[2], second.vv, 3},
                           {names[3], second.tauq, 3}});
  for (std::size_t k = 0; k < tensors.size(); ++k) {
    check_separate(names[k], tensors[k], "q", std::span<const T>(q));
    check_separate(names[k], tensors[k], "v", std::span<const T>(v));
    check_separate(names[k], tensors[k], "tau", std::span<const T>(tau));
  }
  Arena arena = workspace.arena(model.topology());
  HessiansOfAccelerations<T> hessians(arena);
  T* const w = hessians.w;
  const std::ptrdiff_t entries = static_cast<std::ptrdiff_t>(nv) * nv;
  Solvability verdict;
  for (int i = 0; i < nv; ++i) {  // row i of each tensor: the Hessian of a_i
    for (int c = 0; c < nv; ++c) w[c] = T(c == i);
    const auto row = [&](std::size_t k) { return tensors[k].data() + i * entries; };
    const Solvability found = hessians.one.run(model.tree<T>(), q.data(), v.data(), tau.data(), w, {},
                                               {row(0), row(1), row(2), row(3)});
    if (verdict.ok()) verdict = found;
  }
  return solved(verdict, {second.qq, second.qv, second.vv, second.tauq});
}

template void inverse_dynamics_second_derivatives(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                                  Numbers<AXODE_T>, Numbers<AXODE_T>,
                                                  const InverseDynamicsSecondDerivatives<AXODE_T>&);
template Solvability forward_dynamics_second_derivatives(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                                         Numbers<AXODE_T>, Numbers<AXODE_T>,
                                                         const ForwardDynamicsSecondDerivatives<AXODE_T>&);

}  // namespace axode
