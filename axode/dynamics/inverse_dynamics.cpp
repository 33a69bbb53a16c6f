#include "axode/dynamics/inverse_dynamics.hpp"

#include "axode/dynamics/gear_losses.hpp"
#include "axode/fast/inverse_dynamics.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <RecursionChoice Rep, class T>
void inverse_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                      std::type_identity_t<std::span<T>> tau, const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"inverse_dynamics">(model, workspace, q, v, a, loads, tau);
  const Tree<T>& tree = model.tree<T>();
  InverseDynamicsRecursion<Rep, T> recursion{arena};
  recursion.run(tree, q.data(), v.data(), a.data(), loads);
  if (!loads.joint_losses || model.gears().empty()) [[likely]]
    return recursion.project(tree, v.data(), a.data(), loads.joint_losses, tau.data());
  refuse_springs_with_gears("inverse_dynamics",
                            "inverse_dynamics with a LoopWorkspace takes their forces, or simulate", model);
  const GearLosses<T> losses(model, v, a);
  recursion.project(tree, v.data(), a.data(), true, tau.data());
  losses.add(tau);
}

template AXODE_ENTRY decltype(inverse_dynamics<AXODE_REP, AXODE_T>) inverse_dynamics<AXODE_REP, AXODE_T>;

}  // namespace axode
