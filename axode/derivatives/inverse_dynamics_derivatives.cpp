#include "axode/derivatives/inverse_dynamics_derivatives.hpp"

#include "axode/derivatives/displacement/first_order.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
void inverse_dynamics_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                  Numbers<T> a,
                                  const std::type_identity_t<InverseDynamicsDerivatives<T>>& dtau,
                                  const std::type_identity_t<Loads<T>>& loads) {
  Arena arena =
      checked<"inverse_dynamics_derivatives">(model, workspace, q, v, a, loads, dtau.q, dtau.v, dtau.a);
  if (!dtau.tau.empty())
    check_results<T>(
        model,
        {{"dtau.tau", dtau.tau, 1}, {"dtau.q", dtau.q, 2}, {"dtau.v", dtau.v, 2}, {"dtau.a", dtau.a, 2}});
  const Tree<T>& tree = model.tree<T>();
  FirstOrder<T> first_order(arena);
  first_order.run(tree, q.data(), v.data(), a.data(), loads);
  if (!dtau.tau.empty()) first_order.project(tree, v.data(), a.data(), loads.joint_losses, dtau.tau.data());
  first_order.write(tree, loads, dtau.q.data(), dtau.v.data(), dtau.a.data());
}

template AXODE_ENTRY decltype(inverse_dynamics_derivatives<AXODE_T>) inverse_dynamics_derivatives<AXODE_T>;

}  // namespace axode
