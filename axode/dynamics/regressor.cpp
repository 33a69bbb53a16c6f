#include "axode/dynamics/regressor.hpp"

#include "axode/dynamics/inverse_dynamics_recursion.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/path.hpp"

namespace axode {
namespace {

/// The inertia of which one parameter is 1 and the others are 0.
template <class T> Inertia<T> unit_inertia(int k) {
  const auto is = [&](int j) { return T(k == j); };
  return {is(0), {is(1), is(2), is(3)}, {is(4), is(5), is(6), is(7), is(8), is(9)}};
}

/// f(i, V, V') in the frame of every body, body-fixed, with the ground accelerated against gravity.
template <class T, class F>
void each_body(const Tree<T>& tree, typename Workspace<T>::Arena& arena, const T* q, const T* v, const T* a,
               SE3<T>* C, F&& f) {
  const JointMotion<T> joints(arena);
  const BodyMotion<BodyFixed, T> bodies(arena);
  joint_motion(tree, q, v, a, joints);
  forward_recursion(tree, joints, -tree.g, bodies);
  body_poses(tree, joints.C_pi, C);
  for (int i = 1; i <= tree.n; ++i) {
    const Link<BodyFixed, T> user{tree.frame_offset[i]};
    f(i, user.down(bodies.V[i]), user.down(bodies.dV[i]));
  }
}

}  // namespace

std::array<double, 10> inertial_parameters(const Inertia<double>& M) {
  const Sym3<double>& A = M.Theta;
  return {M.m, M.h.x, M.h.y, M.h.z, A.xx, A.yy, A.zz, A.xy, A.xz, A.yz};
}
Inertia<double> inertia_of(std::span<const double, 10> p) {
  return {p[0], {p[1], p[2], p[3]}, {p[4], p[5], p[6], p[7], p[8], p[9]}};
}
std::vector<double> inertial_parameters(const Model& model) {
  std::vector<double> all;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const std::array<double, 10> own = inertial_parameters(model.body(i).M);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

template <class T>
void torque_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                      std::type_identity_t<std::span<T>> Y) {
  check_state(model, workspace, q, v, a);
  const Tree<T>& tree = model.tree<T>();
  const std::size_t width = 10 * static_cast<std::size_t>(tree.n);
  check_size("Y", Y.size(), static_cast<std::size_t>(tree.nv) * width, "nv * 10 * n_bodies");
  for (T& y : Y) y = T(0);
  typename Workspace<T>::Arena arena(workspace);
  SE3<T>* C = arena.template per_body<SE3<T>>();
  each_body(tree, arena, q.data(), v.data(), a.data(), C, [&](int i, const auto& V, const auto& dV) {
    std::array<Wrench<Spatial, T>, 10> W;
    for (int k = 0; k < 10; ++k)
      W[static_cast<std::size_t>(k)] =
          coAd(C[i] * tree.frame_offset[i], newton_euler(unit_inertia<T>(k), V, dV));
    for (int j = i; j > 0; j = tree.parent[j])
      each_screw(tree, j, C[j], [&](int c, const Screw<T>& X) {
        T* y = &Y[static_cast<std::size_t>(c) * width + 10 * static_cast<std::size_t>(i - 1)];
        for (std::size_t k = 0; k < 10; ++k) y[k] += W[k] | twist<Spatial>(X);
      });
  });
}

template <class T>
void kinetic_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              std::type_identity_t<std::span<T>> y) {
  check_state(model, workspace, q, v);
  const Tree<T>& tree = model.tree<T>();
  check_size("y", y.size(), 10 * static_cast<std::size_t>(tree.n), "10 * n_bodies");
  typename Workspace<T>::Arena arena(workspace);
  SE3<T>* C = arena.template per_body<SE3<T>>();
  each_body(tree, arena, q.data(), v.data(), v.data(), C, [&](int i, const auto& V, const auto&) {
    for (int k = 0; k < 10; ++k)
      y[static_cast<std::size_t>(10 * (i - 1) + k)] = T(0.5) * ((unit_inertia<T>(k) * V) | V);
  });
}

template <class T>
void potential_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<T>> y) {
  check_state(model, workspace, q);
  const Tree<T>& tree = model.tree<T>();
  check_size("y", y.size(), 10 * static_cast<std::size_t>(tree.n), "10 * n_bodies");
  typename Workspace<T>::Arena arena(workspace);
  SE3<T>* C_pi = arena.template per_body<SE3<T>>();
  SE3<T>* C = arena.template per_body<SE3<T>>();
  joint_poses(tree, q.data(), C_pi);
  body_poses(tree, C_pi, C);
  for (int i = 1; i <= tree.n; ++i) {
    const SE3<T> C_user = C[i] * tree.frame_offset[i];
    const Vec3<T> g = transpose(C_user.R) * tree.g;
    const std::array<T, 10> own{-dot(tree.g, C_user.r), -g.x, -g.y, -g.z};
    for (std::size_t k = 0; k < 10; ++k) y[10 * static_cast<std::size_t>(i - 1) + k] = own[k];
  }
}

template void torque_regressor(const Model&, Workspace<double>&, Numbers<double>, Numbers<double>,
                               Numbers<double>, std::span<double>);
template void torque_regressor(const Model&, Workspace<float>&, Numbers<float>, Numbers<float>,
                               Numbers<float>, std::span<float>);
template void kinetic_energy_regressor(const Model&, Workspace<double>&, Numbers<double>, Numbers<double>,
                                       std::span<double>);
template void kinetic_energy_regressor(const Model&, Workspace<float>&, Numbers<float>, Numbers<float>,
                                       std::span<float>);
template void potential_energy_regressor(const Model&, Workspace<double>&, Numbers<double>,
                                         std::span<double>);
template void potential_energy_regressor(const Model&, Workspace<float>&, Numbers<float>, std::span<float>);

}  // namespace axode
