#include "axode/derivatives/momentum_form_derivatives.hpp"

#include "axode/derivatives/displacement/momentum_first_order.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
Solvability momentum_form_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                                      const std::type_identity_t<MomentumFormDerivatives<T>>& d,
                                      const std::type_identity_t<Loads<T>>& loads) {
  Arena arena =
      checked<"momentum_form_derivatives">(model, workspace, q, p, loads, d.v_q, d.v_p, d.dp_q, d.dp_p);
  const Solvability verdict = MomentumFirstOrder<T>(arena).run(
      model.tree<T>(), q.data(), p.data(), loads, d.v_q.data(), d.v_p.data(), d.dp_q.data(), d.dp_p.data());
  return solved(verdict, {d.v_q, d.v_p, d.dp_q, d.dp_p});
}

template AXODE_ENTRY decltype(momentum_form_derivatives<AXODE_T>) momentum_form_derivatives<AXODE_T>;

}  // namespace axode
