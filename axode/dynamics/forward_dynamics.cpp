#include "axode/dynamics/forward_dynamics.hpp"

#include <vector>

#include "axode/dynamics/gear_losses.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/fast/forward_dynamics.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/forward_dynamics.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// The accelerations with losses of gears: those without them, and those under the forces of the gears. The
/// results may share memory with the arguments.
template <RecursionChoice Rep, class T>
Solvability accelerate_with_gears(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                  Numbers<T> tau, std::span<T> a, const Loads<T>& loads) {
  const std::vector<T> q_t(q.begin(), q.end()), v_t(v.begin(), v.end());
  std::vector<T> forces(tau.begin(), tau.end());
  const Tree<T>& tree = model.tree<T>();
  const auto accelerate = [&] {
    Arena arena = workspace.arena(model.topology());
    return ForwardDynamicsRecursion<Rep, T>(arena).run(tree, q_t.data(), v_t.data(), forces.data(), loads,
                                                       a.data());
  };
  MovingGears gears(model, v, tau);
  const Solvability found = accelerate();
  if (!found.ok() || gears.velocities().empty()) return found;
  const std::size_t nv = a.size();
  std::vector<T> M_inverse(nv * nv), responses;
  static_cast<void>(inverse_mass_matrix<Rep>(model, workspace, q_t, std::span(M_inverse)));
  for (const int c : gears.velocities())
    responses.insert(responses.end(), M_inverse.begin() + c * static_cast<std::ptrdiff_t>(nv),
                     M_inverse.begin() + (c + 1) * static_cast<std::ptrdiff_t>(nv));
  const Solvability unique =
      gears.add_forces(model, std::span<const T>(a), std::span<const T>(responses), std::span(forces));
  return unique.ok() ? accelerate() : solved(unique, static_cast<std::ptrdiff_t>(nv), a.data());
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
      return accelerate_with_gears<Rep>(model, workspace, q, v, tau, a, loads);
    return ForwardDynamicsRecursion<Rep, T>(arena).run(tree, q.data(), v.data(), tau.data(), loads, a.data());
  }
}

template AXODE_ENTRY Solvability forward_dynamics<AXODE_REP>(const Model&, Workspace<AXODE_T>&,
                                                             Numbers<AXODE_T>, Numbers<AXODE_T>,
                                                             Numbers<AXODE_T>, std::span<AXODE_T>,
                                                             const Loads<AXODE_T>&);

}  // namespace axode
