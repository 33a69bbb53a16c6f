#include "axode/derivatives/term_derivatives.hpp"

#include "axode/derivatives/scratch.hpp"
#include "axode/dynamics/check_loads.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
void gravity_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                         std::type_identity_t<std::span<T>> dq) {
  check_state(model, workspace, q);
  check_square("dq", dq.size(), model);
  const Tree<T>& tree = model.tree<T>();
  Arena arena = workspace.arena(model.topology());
  TermDerivatives<T>(arena).run(tree, q.data(), nullptr, {}, tree.g, dq.data(), nullptr);
}

template <class T>
void coriolis_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                          const std::type_identity_t<StateDerivatives<T>>& d) {
  check_state(model, workspace, q, v);
  check_results<T>(model, {{"d.q", d.q, 2}, {"d.v", d.v, 2}});
  Arena arena = workspace.arena(model.topology());
  TermDerivatives<T>(arena).run(model.tree<T>(), q.data(), v.data(), {}, {}, d.q.data(), d.v.data());
}

template <class T>
void generalized_load_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                  const Loads<T>& loads, const std::type_identity_t<StateDerivatives<T>>& d) {
  check_state(model, workspace, q, v);
  check_loads(model, loads);
  check_results<T>(model, {{"d.q", d.q, 2}, {"d.v", d.v, 2}});
  Arena arena = workspace.arena(model.topology());
  TermDerivatives<T>(arena).run(model.tree<T>(), q.data(), nullptr, loads, {}, d.q.data(), d.v.data());
  for (const std::span<T> matrix : {d.q, d.v})
    for (T& x : matrix) x = -x;
}

template <class T>
void kinetic_energy_gradient(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             const std::type_identity_t<StateDerivatives<T>>& gradient) {
  check_state(model, workspace, q, v);
  check_results<T>(model, {{"gradient.q", gradient.q, 1}, {"gradient.v", gradient.v, 1}});
  const Tree<T>& tree = model.tree<T>();
  Arena arena = workspace.arena(model.topology());
  EnergyGradient<T> s(arena);
  std::fill_n(s.zero, tree->nv, T(0));
  // 2 T = v·τ of the accelerations v from rest, without gravity.
  s.vjp.run(tree, q.data(), s.zero, v.data(), v.data(), {}, {});
  for (std::size_t c = 0; c < gradient.q.size(); ++c) gradient.q[c] = T(0.5) * s.vjp.by_q[c];
  std::copy_n(s.vjp.by_a, gradient.v.size(), gradient.v.data());
}

template void gravity_derivatives(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, std::span<AXODE_T>);
template void coriolis_derivatives(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                   const StateDerivatives<AXODE_T>&);
template void generalized_load_derivatives(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                           Numbers<AXODE_T>, const Loads<AXODE_T>&,
                                           const StateDerivatives<AXODE_T>&);
template void kinetic_energy_gradient(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                      const StateDerivatives<AXODE_T>&);

}  // namespace axode
