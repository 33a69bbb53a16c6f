#include "axode/derivatives/forward_dynamics_derivatives.hpp"

#include "axode/derivatives/forward_first_order.hpp"
#include "axode/dynamics/check_loads.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

template <class T>
Solvability forward_dynamics_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ForwardDynamicsDerivatives<T>>& da,
                                         const std::type_identity_t<Loads<T>>& loads) {
  catalog::check_counts<"forward_dynamics_derivatives">(model, workspace);
  check_state(model, workspace, q, v);
  check_size("tau", tau.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_loads(model, loads);
  check_results<T>(
      model, {{"da.a", da.a, 1, !da.a.empty()}, {"da.q", da.q, 2}, {"da.v", da.v, 2}, {"da.tau", da.tau, 2}});
  Arena arena = workspace.arena(model.topology());
  ForwardFirstOrder<T> first_order(arena);
  const Solvability verdict = first_order.run(model.tree<T>(), q.data(), v.data(), tau.data(), loads,
                                              da.q.data(), da.v.data(), da.tau.data());
  std::copy_n(first_order.forward.a, da.a.size(), da.a.data());
  return solved(verdict, {da.q, da.v, da.tau});
}

template Solvability forward_dynamics_derivatives(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                                  Numbers<AXODE_T>, Numbers<AXODE_T>,
                                                  const ForwardDynamicsDerivatives<AXODE_T>&,
                                                  const Loads<AXODE_T>&);

}  // namespace axode
