#include "axode/derivatives/momentum_form_derivatives.hpp"

#include "axode/derivatives/momentum_first_order.hpp"
#include "axode/dynamics/check_loads.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

template <class T>
Solvability momentum_form_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                                      const std::type_identity_t<MomentumFormDerivatives<T>>& d,
                                      const std::type_identity_t<Loads<T>>& loads) {
  catalog::check_counts<"momentum_form_derivatives">(model, workspace);
  check_state(model, workspace, q);
  check_size("p", p.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_loads(model, loads);
  check_results<T>(model,
                   {{"d.v_q", d.v_q, 2}, {"d.v_p", d.v_p, 2}, {"d.dp_q", d.dp_q, 2}, {"d.dp_p", d.dp_p, 2}});
  for (const std::span<T> matrix : {d.v_q, d.v_p, d.dp_q, d.dp_p})
    check_separate("d", matrix, "q", q), check_separate("d", matrix, "p", p);
  Arena arena = workspace.arena(model.topology());
  const Solvability verdict = MomentumFirstOrder<T>(arena).run(
      model.tree<T>(), q.data(), p.data(), loads, d.v_q.data(), d.v_p.data(), d.dp_q.data(), d.dp_p.data());
  return solved(verdict, {d.v_q, d.v_p, d.dp_q, d.dp_p});
}

template Solvability momentum_form_derivatives(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                               Numbers<AXODE_T>, const MomentumFormDerivatives<AXODE_T>&,
                                               const Loads<AXODE_T>&);

}  // namespace axode
