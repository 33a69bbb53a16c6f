#include "axode/derivatives/term_derivatives.hpp"

#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
void gravity_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                         std::type_identity_t<std::span<T>> dq) {
  Arena arena = checked<"gravity_derivatives">(model, workspace, q, dq);
  const Tree<T>& tree = model.tree<T>();
  TermDerivatives<T>(arena).run(tree, q.data(), nullptr, {}, tree.g, dq.data(), nullptr);
}

template <class T>
void coriolis_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                          const std::type_identity_t<StateDerivatives<T>>& d) {
  Arena arena = checked<"coriolis_derivatives">(model, workspace, q, v, d.q, d.v);
  TermDerivatives<T>(arena).run(model.tree<T>(), q.data(), v.data(), {}, {}, d.q.data(), d.v.data());
}

template <class T>
void generalized_load_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                  const Loads<T>& loads, const std::type_identity_t<StateDerivatives<T>>& d) {
  Arena arena = checked<"generalized_load_derivatives">(model, workspace, q, v, loads, d.q, d.v);
  TermDerivatives<T>(arena).run(model.tree<T>(), q.data(), nullptr, loads, {}, d.q.data(), d.v.data());
  for (const std::span<T> matrix : {d.q, d.v})
    for (T& x : matrix) x = -x;
}

template <class T>
void kinetic_energy_gradient(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             const std::type_identity_t<StateDerivatives<T>>& gradient) {
  Arena arena = checked<"kinetic_energy_gradient">(model, workspace, q, v, gradient.q, gradient.v);
  const Tree<T>& tree = model.tree<T>();
  EnergyGradient<T> s(arena);
  std::fill_n(s.zero, tree->nv, T(0));
  // The kinetic energy is T = v·τ / 2, where τ are the forces for the accelerations v at rest, without
  // gravity.
  s.vjp.run(tree, q.data(), s.zero, v.data(), v.data(), {}, {});
  for (std::size_t c = 0; c < gradient.q.size(); ++c) gradient.q[c] = T(0.5) * s.vjp.by_q[c];
  std::copy_n(s.vjp.by_a, gradient.v.size(), gradient.v.data());
}

template AXODE_ENTRY decltype(gravity_derivatives<AXODE_T>) gravity_derivatives<AXODE_T>;
template AXODE_ENTRY decltype(coriolis_derivatives<AXODE_T>) coriolis_derivatives<AXODE_T>;
template AXODE_ENTRY decltype(generalized_load_derivatives<AXODE_T>) generalized_load_derivatives<AXODE_T>;
template AXODE_ENTRY decltype(kinetic_energy_gradient<AXODE_T>) kinetic_energy_gradient<AXODE_T>;

}  // namespace axode
