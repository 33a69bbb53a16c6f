#include "axode/derivatives/products/products.hpp"

#include "axode/derivatives/displacement/accelerations.hpp"
#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/derivatives/products/inverse_dynamics_products.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
template <class T>
void inverse_dynamics_jvp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                          Numbers<T> a, Numbers<T> dq, Numbers<T> dv, Numbers<T> da,
                          std::type_identity_t<std::span<T>> dtau,
                          const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"inverse_dynamics_jvp">(model, workspace, q, v, a, dq, dv, da, loads, dtau);
  InverseDynamicsJvp<T>(arena).run(model.tree<T>(), q.data(), v.data(), a.data(), dq.data(), dv.data(),
                                   da.data(), loads, dtau.data());
}

template <class T>
void inverse_dynamics_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                          Numbers<T> a, Numbers<T> w,
                          const std::type_identity_t<InverseDynamicsGradients<T>>& gradient,
                          const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"inverse_dynamics_vjp">(model, workspace, q, v, a, w, loads, gradient.q, gradient.v,
                                                gradient.a);
  InverseDynamicsVjp<T> vjp(arena);
  vjp.run(model.tree<T>(), q.data(), v.data(), a.data(), w.data(), loads);
  std::copy_n(vjp.by_q, gradient.q.size(), gradient.q.data());
  std::copy_n(vjp.by_v, gradient.v.size(), gradient.v.data());
  std::copy_n(vjp.by_a, gradient.a.size(), gradient.a.data());
}

template <class T>
Solvability forward_dynamics_jvp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> tau, Numbers<T> dq, Numbers<T> dv, Numbers<T> dtau,
                                 std::type_identity_t<std::span<T>> da,
                                 const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"forward_dynamics_jvp">(model, workspace, q, v, tau, dq, dv, dtau, loads, da);
  ForwardJvp<T> s(arena);
  const Tree<T>& tree = model.tree<T>();
  const Solvability verdict =
      s.run(tree, q.data(), v.data(), tau.data(), dq.data(), dv.data(), dtau.data(), loads);
  std::copy_n(s.x, da.size(), da.data());
  return solved(verdict, tree->nv, da.data());
}

template <class T>
Solvability forward_dynamics_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> tau, Numbers<T> w,
                                 const std::type_identity_t<ForwardDynamicsGradients<T>>& gradient,
                                 const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"forward_dynamics_vjp">(model, workspace, q, v, tau, w, loads, gradient.q, gradient.v,
                                                gradient.tau);
  ForwardVjp<T> s(arena);
  const Tree<T>& tree = model.tree<T>();
  const int nv = tree->nv;
  const Solvability verdict = s.run(tree, q.data(), v.data(), tau.data(), w.data(), loads);
  std::copy_n(s.vjp.by_q, nv, gradient.q.data());
  std::copy_n(s.vjp.by_v, nv, gradient.v.data());
  std::copy_n(s.mu, nv, gradient.tau.data());
  return solved(verdict, {gradient.q, gradient.v, gradient.tau});
}

template AXODE_ENTRY decltype(inverse_dynamics_jvp<AXODE_T>) inverse_dynamics_jvp<AXODE_T>;
template AXODE_ENTRY decltype(inverse_dynamics_vjp<AXODE_T>) inverse_dynamics_vjp<AXODE_T>;
template AXODE_ENTRY decltype(forward_dynamics_jvp<AXODE_T>) forward_dynamics_jvp<AXODE_T>;
template AXODE_ENTRY decltype(forward_dynamics_vjp<AXODE_T>) forward_dynamics_vjp<AXODE_T>;

}  // namespace axode
