#include "axode/dynamics/forward_dynamics.hpp"

#include <algorithm>
#include <vector>

#include "axode/dynamics/gear_losses.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/fast/forward_dynamics.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/forward_dynamics.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

template <RecursionChoice Rep, class T>
Solvability with_gears(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                       Numbers<T> tau, std::span<T> a, const Loads<T>& loads) {
  return accelerate_with_gears<T>(
      model, q, v, tau, a,
      [&](const T* q_t, const T* v_t, const T* forces) {
        Arena arena = workspace.arena(model.topology());
        return ForwardDynamicsRecursion<Rep, T>(arena).run(model.tree<T>(), q_t, v_t, forces, loads,
                                                           a.data());
      },
      [&](const T* q_t, std::span<const int> velocities, T* responses) {
        std::vector<T> M_inverse(a.size() * a.size());
        static_cast<void>(
            inverse_mass_matrix<Rep>(model, workspace, Numbers<T>(q_t, q.size()), std::span(M_inverse)));
        for (const int c : velocities)
          responses = std::copy_n(M_inverse.begin() + c * std::ssize(a), a.size(), responses);
      });
}

}  // namespace

template <RecursionChoice Rep, class T>
Solvability forward_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"forward_dynamics">(model, workspace, q, v, tau, loads, a);
  const Tree<T>& tree = model.tree<T>();
  if constexpr (std::same_as<Rep, Fast>) {
    const bool gears = loads.joint_losses && !model.gears().empty();
    if (!gears && FastForwardDynamics<T>(arena).run(tree, q.data(), v.data(), tau.data(), loads, a.data()))
      return solved(Solvability{}, tree->nv, a.data());
    return forward_dynamics<Hybrid>(model, workspace, q, v, tau, a, loads);
  } else {
    if (loads.joint_losses && !model.gears().empty()) [[unlikely]]
      return with_gears<Rep>(model, workspace, q, v, tau, a, loads);
    return ForwardDynamicsRecursion<Rep, T>(arena).run(tree, q.data(), v.data(), tau.data(), loads, a.data());
  }
}

template AXODE_ENTRY decltype(forward_dynamics<AXODE_REP, AXODE_T>) forward_dynamics<AXODE_REP, AXODE_T>;

}  // namespace axode
