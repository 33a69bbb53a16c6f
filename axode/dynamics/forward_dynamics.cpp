#include "axode/dynamics/forward_dynamics.hpp"

#include "axode/fast/forward_dynamics.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/forward_dynamics.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <RecursionChoice Rep, class T>
Solvability forward_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"forward_dynamics">(model, workspace, q, v, tau, loads, a);
  const Tree<T>& tree = model.tree<T>();
  if constexpr (std::same_as<Rep, Fast>) {
    if (FastForwardDynamics<T>(arena).run(tree, q.data(), v.data(), tau.data(), loads, a.data()))
      return solved(Solvability{}, tree->nv, a.data());
    return forward_dynamics<Hybrid>(model, workspace, q, v, tau, a, loads);
  } else {
    return ForwardDynamicsRecursion<Rep, T>(arena).run(tree, q.data(), v.data(), tau.data(), loads, a.data());
  }
}

template AXODE_ENTRY Solvability forward_dynamics<AXODE_REP>(const Model&, Workspace<AXODE_T>&,
                                                             Numbers<AXODE_T>, Numbers<AXODE_T>,
                                                             Numbers<AXODE_T>, std::span<AXODE_T>,
                                                             const Loads<AXODE_T>&);

}  // namespace axode
