#include "axode/derivatives/forward_dynamics_derivatives.hpp"

#include "axode/derivatives/displacement/forward_first_order.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
Solvability forward_dynamics_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ForwardDynamicsDerivatives<T>>& da,
                                         const std::type_identity_t<Loads<T>>& loads) {
  Arena arena =
      checked<"forward_dynamics_derivatives">(model, workspace, q, v, tau, loads, da.q, da.v, da.tau);
  if (!da.a.empty())
    check_results<T>(model, {{"da.a", da.a, 1}, {"da.q", da.q, 2}, {"da.v", da.v, 2}, {"da.tau", da.tau, 2}});
  ForwardFirstOrder<T> first_order(arena);
  const Solvability verdict = first_order.run(model.tree<T>(), q.data(), v.data(), tau.data(), loads,
                                              da.q.data(), da.v.data(), da.tau.data());
  std::copy_n(first_order.forward.a, da.a.size(), da.a.data());
  return solved(verdict, {da.q, da.v, da.tau});
}

template AXODE_ENTRY decltype(forward_dynamics_derivatives<AXODE_T>) forward_dynamics_derivatives<AXODE_T>;

}  // namespace axode
