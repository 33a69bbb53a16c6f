#include "axode/dynamics/forward_dynamics.hpp"

#include "axode/dynamics/check_loads.hpp"
#include "axode/fast/articulated_bodies.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/forward_dynamics.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

template <RecursionChoice Rep, class T>
Solvability forward_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             const std::type_identity_t<Loads<T>>& loads) {
  catalog::check_counts<"forward_dynamics">(model, workspace);
  check_state(model, workspace, q, v);
  check_size("tau", tau.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_size("a", a.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_loads(model, loads);
  Arena arena = workspace.arena(model.topology());
  const Tree<T>& tree = model.tree<T>();
  if constexpr (std::same_as<Rep, Fast>) {
    if (FastForwardDynamics<T>(arena).run(tree, q.data(), v.data(), tau.data(), loads, a.data()))
      return solved(Solvability{}, tree->nv, a.data());
    return forward_dynamics<Hybrid>(model, workspace, q, v, tau, a, loads);
  } else {
    return ForwardDynamicsRecursion<Rep, T>(arena).run(tree, q.data(), v.data(), tau.data(), loads, a.data());
  }
}

template Solvability forward_dynamics<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                                 Numbers<AXODE_T>, Numbers<AXODE_T>, std::span<AXODE_T>,
                                                 const Loads<AXODE_T>&);

}  // namespace axode
