#include "axode/derivatives/forward_dynamics_derivatives.hpp"

#include "axode/derivatives/forward_first_order.hpp"
#include "axode/dynamics/check_loads.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
Solvability forward_dynamics_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ForwardDynamicsDerivatives<T>>& da,
                                         const std::type_identity_t<Loads<T>>& loads) {
  check_state(model, workspace, q, v);
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  check_size("tau", tau.size(), nv, "nv");
  check_loads(model, loads);
  check_square("da.q", da.q.size(), model);
  check_square("da.v", da.v.size(), model);
  check_square("da.tau", da.tau.size(), model);
  check_separate("da.q", da.q, "da.v", da.v);
  check_separate("da.q", da.q, "da.tau", da.tau);
  check_separate("da.v", da.v, "da.tau", da.tau);
  if (!da.a.empty()) check_size("da.a", da.a.size(), nv, "nv");
  Arena arena = workspace.arena(model.topology());
  ForwardFirstOrder<T> first_order(arena);
  const Solvability verdict = first_order.run(model.tree<T>(), q.data(), v.data(), tau.data(), loads,
                                              da.q.data(), da.v.data(), da.tau.data());
  std::copy_n(first_order.forward.a, da.a.size(), da.a.data());
  return verdict;
}

template Solvability forward_dynamics_derivatives(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                                  Numbers<AXODE_T>, Numbers<AXODE_T>,
                                                  const ForwardDynamicsDerivatives<AXODE_T>&,
                                                  const Loads<AXODE_T>&);

}  // namespace axode
