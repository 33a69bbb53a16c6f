#include "axode/derivatives/second_order/hessian.hpp"

#include "axode/derivatives/second_order/forward_second_order.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
void inverse_dynamics_hessian(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              Numbers<T> a, Numbers<T> w,
                              const std::type_identity_t<InverseDynamicsHessian<T>>& h,
                              const std::type_identity_t<Loads<T>>& loads) {
  Arena arena =
      checked<"inverse_dynamics_hessian">(model, workspace, q, v, a, w, loads, h.qq, h.qv, h.vv, h.aq);
  SecondOrder<T> second(arena);
  second.run(model.tree<T>(), q.data(), v.data(), a.data(), w.data(), loads);
  const HessianBlocks<T> blocks{h.qq.data(), h.qv.data(), h.vv.data(), h.aq.data()};
  if (model.topology().coupled_bodies.empty())
    return second.write(model.topology(), !loads.wrenches.empty(), blocks);
  for (const std::span<T> block : {h.qq, h.qv, h.vv, h.aq}) std::fill(block.begin(), block.end(), T(0));
  second.add_to(model.topology(), !loads.wrenches.empty(), blocks);
}

template <class T>
Solvability forward_dynamics_hessian(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     Numbers<T> tau, Numbers<T> w,
                                     const std::type_identity_t<ForwardDynamicsHessian<T>>& h,
                                     const std::type_identity_t<Loads<T>>& loads) {
  Arena arena =
      checked<"forward_dynamics_hessian">(model, workspace, q, v, tau, w, loads, h.qq, h.qv, h.vv, h.tauq);
  const Solvability verdict =
      ForwardSecondOrder<T>(arena).run(model.tree<T>(), q.data(), v.data(), tau.data(), w.data(), loads,
                                       {h.qq.data(), h.qv.data(), h.vv.data(), h.tauq.data()});
  return solved(verdict, {h.qq, h.qv, h.vv, h.tauq});
}

template AXODE_ENTRY decltype(inverse_dynamics_hessian<AXODE_T>) inverse_dynamics_hessian<AXODE_T>;
template AXODE_ENTRY decltype(forward_dynamics_hessian<AXODE_T>) forward_dynamics_hessian<AXODE_T>;

}  // namespace axode
