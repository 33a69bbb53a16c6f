#include "axode/dynamics/momentum/momentum_form.hpp"

#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T>
Solvability momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                          Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                          std::type_identity_t<std::span<T>> dp,
                          const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"momentum_form">(model, workspace, q, p, tau, loads, v, dp);
  return MomentumForm<T>(arena).run(model.tree<T>(), q.data(), p.data(), tau.data(), loads, v.data(),
                                    dp.data());
}

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
  const Tree<T>& tree = model.tree<T>();
  Arena arena = workspace.arena(model.topology());
  StateForm<Spatial, T> at(arena);
  at.spatial.run(tree, q.data());

  // Solves (JᵀMJ) v = JᵀΠ, without armatures, because these have no part in the momenta of the bodies.
  at.Pi[0] = {};
  for (int i = 1; i <= tree->n; ++i) {
    const Momentum<Spatial, T>& given = Pi[i - 1];  // the given momentum is about the inertial origin
    at.Pi[i] = {given.l - cross(at.spatial.origin[i], given.p), given.p};
  }
  sum_subtrees(*tree.topology(), at.Pi);
  for (int c = 0; c < tree->nv; ++c) at.v[c] = at.zero[c] = T(0);
  for (int i = 1; i <= tree->n; ++i)
    at.spatial.each_screw(i, [&](int c, const Twist<Spatial, T>& J) { at.v[c] += at.Pi[i] | J; });
  use(at.spatial, at.bodies);
  Solvability verdict = at.bodies.eliminate_joints(tree, at.zero);
  if (verdict.ok()) at.bodies.solve(tree, at.v);
  verdict = solved(verdict, tree->nv, at.v);

  const Solvability accelerated = at.dynamics.run(tree, q.data(), at.v, tau.data(), loads, at.a);
  at.motion.run(tree, q.data(), at.v, at.a);
  const auto& [link, V, dV] = at.motion.bodies;
  for (int i = 1; i <= tree->n; ++i) dPi[i - 1] = link[i].newton_euler(tree.M[i], V[i], dV[i]);
  for (int c = 0; c < tree->nv; ++c) v[c] = at.v[c];
  return verdict.ok() ? accelerated : verdict;
}

template AXODE_ENTRY Solvability momentum_form(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                               Numbers<AXODE_T>, Numbers<AXODE_T>, std::span<AXODE_T>,
                                               std::span<AXODE_T>, const Loads<AXODE_T>&);
template AXODE_ENTRY Solvability spatial_momentum_form(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                                       std::span<const Momentum<Spatial, AXODE_T>>,
                                                       Numbers<AXODE_T>, std::span<AXODE_T>,
                                                       std::span<Wrench<Spatial, AXODE_T>>,
                                                       const Loads<AXODE_T>&);

}  // namespace axode
