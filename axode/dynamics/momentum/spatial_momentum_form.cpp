#include "axode/dynamics/momentum/spatial_momentum_form.hpp"

#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/recursion/momentum.hpp"

namespace axode {

template <class T>
Solvability spatial_momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                  std::type_identity_t<std::span<const Momentum<Spatial, T>>> Pi,
                                  Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                                  std::type_identity_t<std::span<Wrench<Spatial, T>>> dPi,
                                  const std::type_identity_t<Loads<T>>& loads) {
  check_state(model, workspace, q);
  check_size("Pi", Pi.size(), static_cast<std::size_t>(model.n_bodies()), "n_bodies");
  check_size("tau", tau.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_size("dPi", dPi.size(), static_cast<std::size_t>(model.n_bodies()), "n_bodies");
  check_separate("v", v, "dPi", dPi);
  check_loads(model, loads);
  Arena arena = workspace.arena(model.topology());
  return SpatialMomentumForm<T>(arena).run(model.tree<T>(), q.data(), Pi.data(), tau.data(), loads, v.data(),
                                           dPi.data());
}

template AXODE_ENTRY decltype(spatial_momentum_form<AXODE_T>) spatial_momentum_form<AXODE_T>;

}  // namespace axode
