#include "axode/dynamics/momentum/momentum_form.hpp"

#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/recursion/momentum.hpp"

namespace axode {

template <RecursionRepresentation Rep, class T>
Solvability momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                          Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                          std::type_identity_t<std::span<T>> dp,
                          const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"momentum_form">(model, workspace, q, p, tau, loads, v, dp);
  return MomentumForm<Rep, T>(arena).run(model.tree<T>(), q.data(), p.data(), tau.data(), loads, v.data(),
                                         dp.data());
}

template decltype(momentum_form<AXODE_REP, AXODE_T>) momentum_form<AXODE_REP, AXODE_T>;

}  // namespace axode
