#include "axode/dynamics/inverse_dynamics.hpp"

#include "axode/dynamics/check_loads.hpp"
#include "axode/fast/inverse_dynamics.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

template <RecursionChoice Rep, class T>
void inverse_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                      std::type_identity_t<std::span<T>> tau, const std::type_identity_t<Loads<T>>& loads) {
  catalog::check_counts<"inverse_dynamics">(model, workspace);
  check_state(model, workspace, q, v, a);
  check_loads(model, loads);
  check_size("tau", tau.size(), static_cast<std::size_t>(model.nv()), "nv");
  const Tree<T>& tree = model.tree<T>();
  Arena arena = workspace.arena(model.topology());
  InverseDynamicsRecursion<Rep, T> recursion{arena};
  recursion.run(tree, q.data(), v.data(), a.data(), loads);
  recursion.project(tree, v.data(), a.data(), loads.joint_losses, tau.data());
}

template void inverse_dynamics<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                          Numbers<AXODE_T>, Numbers<AXODE_T>, std::span<AXODE_T>,
                                          const Loads<AXODE_T>&);

}  // namespace axode
