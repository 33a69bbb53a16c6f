#include "axode/dynamics/momentum.hpp"

#include <utility>

#include "axode/dynamics/check_loads.hpp"
#include "axode/dynamics/energy.hpp"
#include "axode/dynamics/momentum_recursion.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/mass_center.hpp"

namespace axode {
namespace {

template <class T> void require_mass(const Model& model, const Inertia<T>& whole) {
  if (!(whole.m > T(0))) throw no_mass(model);
}

}  // namespace

template <class T>
void generalized_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                         std::type_identity_t<std::span<T>> p) {
  check_state(model, workspace, q, v);
  check_size("p", p.size(), static_cast<std::size_t>(model.nv()), "nv");
  const Tree<T>& tree = model.tree<T>();
  SpatialTree<T> s(tree, workspace, q.data());
  const Momentum<Spatial, T>* Pi = subtree_momenta(s, twists_at(s, v.data()));
  for (int c = 0; c < tree.nv; ++c) p[c] = tree.armature[c] * v[c];
  for (int i = 1; i <= tree.n; ++i)
    s.each_screw(i, [&](int c, const Twist<Spatial, T>& J) { p[c] += Pi[i] | J; });
}

template <class T>
Solvability momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                          Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                          std::type_identity_t<std::span<T>> dp,
                          const std::type_identity_t<Loads<T>>& loads) {
  check_state(model, workspace, q);
  for (const auto& [name, size] :
       {std::pair{"p", p.size()}, {"tau", tau.size()}, {"v", v.size()}, {"dp", dp.size()}})
    check_size(name, size, static_cast<std::size_t>(model.nv()), "nv");
  check_loads(model, loads);
  return solve_momentum_form(model.tree<T>(), workspace, q.data(), p.data(), tau.data(), loads, v.data(),
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
  check_loads(model, loads);
  const Tree<T>& tree = model.tree<T>();
  SpatialTree<T> s(tree, workspace, q.data());
  typename Workspace<T>::Arena rest = s.arena;

  // (JᵀMJ) v = JᵀΠ, without armatures: they have no part in the momenta of the bodies.
  Momentum<Spatial, T>* Pi_A = rest.template per_body<Momentum<Spatial, T>>();
  T* zero = rest.template per_screw<T>();
  Pi_A[0] = {};
  for (int i = 1; i <= tree.n; ++i) Pi_A[i] = Pi[i - 1];
  sum_subtrees(tree, Pi_A);
  for (int c = 0; c < tree.nv; ++c) v[c] = zero[c] = T(0);
  for (int i = 1; i <= tree.n; ++i)
    s.each_screw(i, [&](int c, const Twist<Spatial, T>& J) { v[c] += Pi_A[i] | J; });
  const MassMatrixSolver<Spatial, T> solver{tree, rest, s.link, zero};
  solver.solve(v.data());

  typename Workspace<T>::Arena arena(workspace);
  T* a = arena.template per_screw<T>();
  const Solvability solvability =
      solve_forward_dynamics<Spatial>(tree, arena, q.data(), v.data(), tau.data(), loads, a);
  const JointMotion<T> joints(arena);
  const BodyMotion<Spatial, T> bodies(arena);
  joint_motion(tree, q.data(), v.data(), a, joints);
  forward_recursion(tree, joints, Vec3<T>{}, bodies);
  for (int i = 1; i <= tree.n; ++i)
    dPi[i - 1] = newton_euler(bodies.link[i], tree.M[i], bodies.V[i], bodies.dV[i]);
  return solver.solvability().ok() ? solvability : solver.solvability();
}

template <class T>
Momentum<Spatial, T> spatial_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                      Numbers<T> v) {
  check_state(model, workspace, q, v);
  SpatialTree<T> s(model.tree<T>(), workspace, q.data());
  return subtree_momenta(s, twists_at(s, v.data()))[0];
}

template <class T>
Momentum<Hybrid, T> centroidal_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                        Numbers<T> v) {
  check_state(model, workspace, q, v);
  SpatialTree<T> s(model.tree<T>(), workspace, q.data());
  require_mass(model, s.M[0]);
  const Momentum<Spatial, T> Pi = subtree_momenta(s, twists_at(s, v.data()))[0];
  return {Pi.l - cross(center_of_mass(s.M[0]), Pi.p), Pi.p};
}

template <class T> T kinetic_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v) {
  check_state(model, workspace, q, v);
  const Tree<T>& tree = model.tree<T>();
  SpatialTree<T> s(tree, workspace, q.data());
  const Twist<Spatial, T>* V = twists_at(s, v.data());
  T twice(0);
  for (int i = 1; i <= tree.n; ++i) twice += (s.M_body[i] * V[i]) | V[i];
  for (int c = 0; c < tree.nv; ++c) twice += tree.armature[c] * v[c] * v[c];
  return T(0.5) * twice;
}

template <class T> T potential_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q) {
  check_state(model, workspace, q);
  const SpatialTree<T> s(model.tree<T>(), workspace, q.data());
  return -dot(s.tree.g, s.M[0].h);
}

template <class T>
void load_powers(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                 const std::type_identity_t<Loads<T>>& loads, std::type_identity_t<std::span<T>> power) {
  check_state(model, workspace, q, v);
  check_loads(model, loads);
  check_size("power", power.size(), loads.wrenches.size(), "number of wrenches");
  const Tree<T>& tree = model.tree<T>();
  SpatialTree<T> s(tree, workspace, q.data());
  const Twist<Spatial, T>* V = twists_at(s, v.data());
  for (std::size_t k = 0; k < power.size(); ++k) {
    const AppliedWrench<T>& load = loads.wrenches[k];
    const int i = tree.frame_body[load.frame];
    const SE3<T> C = s.link[i].C * tree.frame_offset[load.frame];
    power[k] = with_representation(load.representation, [&](auto rep) {
      return change<BodyFixed>(C, Wrench<decltype(rep), T>{load.m, load.f}) | change<BodyFixed>(C, V[i]);
    });
  }
}

template <class T> Inertia<T> centroidal_inertia(const Model& model, Workspace<T>& workspace, Numbers<T> q) {
  check_state(model, workspace, q);
  const SpatialTree<T> s(model.tree<T>(), workspace, q.data());
  require_mass(model, s.M[0]);
  return {s.M[0].m, {}, inertia_about_com(s.M[0])};
}

template void generalized_momenta(const Model&, Workspace<double>&, Numbers<double>, Numbers<double>,
                                  std::span<double>);
template Solvability momentum_form(const Model&, Workspace<double>&, Numbers<double>, Numbers<double>,
                                   Numbers<double>, std::span<double>, std::span<double>,
                                   const Loads<double>&);
template Solvability spatial_momentum_form(const Model&, Workspace<double>&, Numbers<double>,
                                           std::span<const Momentum<Spatial, double>>, Numbers<double>,
                                           std::span<double>, std::span<Wrench<Spatial, double>>,
                                           const Loads<double>&);
template Momentum<Spatial, double> spatial_momentum(const Model&, Workspace<double>&, Numbers<double>,
                                                    Numbers<double>);
template Momentum<Hybrid, double> centroidal_momentum(const Model&, Workspace<double>&, Numbers<double>,
                                                      Numbers<double>);
template double kinetic_energy(const Model&, Workspace<double>&, Numbers<double>, Numbers<double>);
template double potential_energy(const Model&, Workspace<double>&, Numbers<double>);
template void load_powers(const Model&, Workspace<double>&, Numbers<double>, Numbers<double>,
                          const Loads<double>&, std::span<double>);
template Inertia<double> centroidal_inertia(const Model&, Workspace<double>&, Numbers<double>);
template void generalized_momenta(const Model&, Workspace<float>&, Numbers<float>, Numbers<float>,
                                  std::span<float>);
template Solvability momentum_form(const Model&, Workspace<float>&, Numbers<float>, Numbers<float>,
                                   Numbers<float>, std::span<float>, std::span<float>, const Loads<float>&);
template Solvability spatial_momentum_form(const Model&, Workspace<float>&, Numbers<float>,
                                           std::span<const Momentum<Spatial, float>>, Numbers<float>,
                                           std::span<float>, std::span<Wrench<Spatial, float>>,
                                           const Loads<float>&);
template Momentum<Spatial, float> spatial_momentum(const Model&, Workspace<float>&, Numbers<float>,
                                                   Numbers<float>);
template Momentum<Hybrid, float> centroidal_momentum(const Model&, Workspace<float>&, Numbers<float>,
                                                     Numbers<float>);
template float kinetic_energy(const Model&, Workspace<float>&, Numbers<float>, Numbers<float>);
template float potential_energy(const Model&, Workspace<float>&, Numbers<float>);
template void load_powers(const Model&, Workspace<float>&, Numbers<float>, Numbers<float>,
                          const Loads<float>&, std::span<float>);
template Inertia<float> centroidal_inertia(const Model&, Workspace<float>&, Numbers<float>);

}  // namespace axode
