#include "axode/dynamics/closed_form/twist_form.hpp"

#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// Computes the joint velocities v_i = (SᵀS)⁻¹ Sᵀ (V_i - V_p) from the twists V_i of each body and V_p of its
/// predecessor, in the joint frame, where the columns of the joint screws S are orthogonal.
template <class Rep, class T>
void velocities(const Tree<T>& tree, const T* q, const Twist<Rep, T>* V, StateForm<Rep, T>& at) noexcept {
  at.C.run(tree, q);
  at.V_s[0] = {};
  for (int i = 1; i <= tree->n; ++i) {
    const SE3<T> C_user = at.C[i] * tree.frame_offset[i];
    at.V_s[i] = change<Spatial>(C_user, change<BodyFixed>(C_user, V[i - 1]));
  }
  each_joint(tree, [&](const auto& joint, int i, bool coupled) {
    if (coupled) return;  // a coupled joint moves as its leader does
    const Twist<BodyFixed, T> X = Ad_inv(at.C[i], at.V_s[i] - at.V_s[tree->parent[i]]);
    for (int k = 0; k < joint.nv; ++k) {
      const Screw<T> S = joint.column(k);
      at.v[tree->iv[i] + k] = (dot(S.w, X.w) + dot(S.v, X.v)) / (dot(S.w, S.w) + dot(S.v, S.v));
    }
  });
}

}  // namespace

template <RecursionRepresentation Rep, class T>
Solvability twist_form(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       std::type_identity_t<std::span<const Twist<Rep, T>>> V, Numbers<T> tau,
                       std::type_identity_t<std::span<T>> v,
                       std::type_identity_t<std::span<TwistRate<Rep, T>>> dV,
                       const std::type_identity_t<Loads<T>>& loads) {
  const std::size_t n = static_cast<std::size_t>(model.n_bodies());
  check_state(model, workspace, q);
  check_size("V", V.size(), n, "n_bodies");
  check_size("tau", tau.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_size("dV", dV.size(), n, "n_bodies");
  check_separate("v", v, "dV", dV);
  check_loads(model, loads);
  const Tree<T>& tree = model.tree<T>();
  Arena arena = workspace.arena(model.topology());
  StateForm<Rep, T> at(arena);
  velocities(tree, q.data(), V.data(), at);
  const Solvability verdict = at.dynamics.run(tree, q.data(), at.v, tau.data(), loads, at.a);
  at.motion.run(tree, q.data(), at.v, at.a);
  const auto& [link, V_i, dV_i] = at.motion.bodies;
  for (int i = 1; i <= tree->n; ++i) {
    const Link<Rep, T> user = link[i].child(tree.frame_offset[i]);
    dV[i - 1] = user.down(dV_i[i]) + user.bias(V_i[i], user.down(V_i[i]), Twist<Rep, T>{});
  }
  for (int c = 0; c < tree->nv; ++c) v[c] = at.v[c];
  return verdict;
}

template decltype(twist_form<AXODE_REP, AXODE_T>) twist_form<AXODE_REP, AXODE_T>;

}  // namespace axode
