#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/fast_poses.hpp"
#include "axode/kinematics/forward_recursion.hpp"
#include "axode/kinematics/jacobian.hpp"
#include "axode/kinematics/mass_center.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/lie/inertia.hpp"

namespace axode {
namespace {

template <class T>
SE3<T>* internal_poses(const Tree<T>& tree, typename Workspace<T>::Arena& arena, const T* q) noexcept {
  SE3<T>* C_pi = arena.template per_body<SE3<T>>();
  SE3<T>* C = arena.template per_body<SE3<T>>();
  joint_poses(tree, q, C_pi);
  body_poses(tree, C_pi, C);
  return C;
}

/// The inertia of everything that a joint moves, M_i^A = Σ M_l^s over the subtree of i, about the centre of
/// mass of the whole in inertial axes. Moves the poses C there, and returns where it was.
template <class T>
Vec3<T> subtree_inertias(const Model& model, const Tree<T>& tree, SE3<T>* C, Inertia<T>* M) {
  const Vec3<T> c = mass_center(model, tree, C);
  for (int i = 1; i <= tree.n; ++i) {
    C[i].r -= c;
    M[i] = transform(C[i], tree.M[i]);
  }
  M[0] = {};
  for (int i = tree.n; i > 0; --i) M[tree.parent[i]] += M[i];
  return c;
}

}  // namespace

template <class T>
void joint_screws(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                  std::type_identity_t<std::span<Twist<Spatial, T>>> J) {
  check_state(model, workspace, q);
  check_size("J", J.size(), static_cast<std::size_t>(model.n_screws()), "n_screws");
  const Tree<T>& tree = model.tree<T>();
  typename Workspace<T>::Arena arena(workspace);
  FastPoses<T> poses(arena);
  poses.run(tree, q.data(), [&](int i, const auto& at) {
    Twist<Spatial, T>* J_i = J.data() + tree.first_screw[i];
    if (is_hinge(tree, i)) [[likely]] {
      using Factor = typename FastPoses<T>::G::Factor;
      J_i[0] = {at.R.z, cross(Factor(at.r), Factor(at.R.z))};
    } else {
      with_joint(tree, i, [&](const auto& joint) {
        const SE3<T> C = pose<T>(at);
        for (int k = 0; k < joint.nv; ++k) J_i[k] = twist<Spatial>(joint.column(C, k));
      });
    }
  });
}

template <class T>
void center_of_mass_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             std::type_identity_t<std::span<Vec3<T>>> J) {
  check_state(model, workspace, q);
  check_size("J", J.size(), static_cast<std::size_t>(model.nv()), "nv");
  const Tree<T>& tree = model.tree<T>();
  typename Workspace<T>::Arena arena(workspace);
  SE3<T>* C = internal_poses(tree, arena, q.data());
  Inertia<T>* M = arena.template per_body<Inertia<T>>();
  subtree_inertias(model, tree, C, M);
  for (Vec3<T>& column : J) column = {};
  for (int i = 1; i <= tree.n; ++i)
    each_screw(tree, i, C[i], [&](int c, const Screw<T>& X) {
      J[c] += (T(1) / M[0].m) * (M[i] * twist<Spatial>(X)).p;  // momentum of the subtree for a unit velocity
    });
}

template <class T>
void centroidal_momentum_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<Momentum<Hybrid, T>>> A) {
  check_state(model, workspace, q);
  check_size("A", A.size(), static_cast<std::size_t>(model.nv()), "nv");
  const Tree<T>& tree = model.tree<T>();
  typename Workspace<T>::Arena arena(workspace);
  SE3<T>* C = internal_poses(tree, arena, q.data());
  Inertia<T>* M = arena.template per_body<Inertia<T>>();
  subtree_inertias(model, tree, C, M);
  for (Momentum<Hybrid, T>& column : A) column = {};
  for (int i = 1; i <= tree.n; ++i)
    each_screw(tree, i, C[i], [&](int c, const Screw<T>& X) {
      const Momentum<Spatial, T> Pi = M[i] * twist<Spatial>(X);
      A[c] += Momentum<Hybrid, T>{Pi.l, Pi.p};
    });
}

template <class T>
void centroidal_momentum_matrix_rate(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     std::type_identity_t<std::span<Wrench<Hybrid, T>>> dA) {
  check_state(model, workspace, q, v);
  check_size("dA", dA.size(), static_cast<std::size_t>(model.nv()), "nv");
  const Tree<T>& tree = model.tree<T>();
  typename Workspace<T>::Arena arena(workspace);
  SE3<T>* C = internal_poses(tree, arena, q.data());
  Inertia<T>* M = arena.template per_body<Inertia<T>>();
  Inertia<T>* dM = arena.template per_body<Inertia<T>>();
  Twist<Spatial, T>* V = arena.template per_body<Twist<Spatial, T>>();
  subtree_inertias(model, tree, C, M);
  V[0] = {}, dM[0] = {};
  for (int i = 1; i <= tree.n; ++i) {
    V[i] = V[tree.parent[i]];
    each_screw(tree, i, C[i], [&](int c, const Screw<T>& X) { V[i] += v[c] * twist<Spatial>(X); });
    dM[i] = inertia_rate(V[i], transform(C[i], tree.M[i]));
  }
  for (int i = tree.n; i > 0; --i) dM[tree.parent[i]] += dM[i];
  const Vec3<T> dc =
      (T(1) / M[0].m) * dM[0].h;  // velocity of the centre of mass, about which moments are taken
  for (Wrench<Hybrid, T>& column : dA) column = {};
  for (int i = 1; i <= tree.n; ++i)
    each_screw(tree, i, C[i], [&](int c, const Screw<T>& X) {
      const Twist<Spatial, T> J = twist<Spatial>(X), dJ = ad(V[i], J);
      const Momentum<Spatial, T> Pi = M[i] * J, dPi = dM[i] * J + M[i] * dJ;
      dA[c] += Wrench<Hybrid, T>{dPi.l - cross(dc, Pi.p), dPi.p};
    });
}

template void joint_screws(const Model&, Workspace<double>&, Numbers<double>,
                           std::span<Twist<Spatial, double>>);
template void joint_screws(const Model&, Workspace<float>&, Numbers<float>, std::span<Twist<Spatial, float>>);
template void center_of_mass_jacobian(const Model&, Workspace<double>&, Numbers<double>,
                                      std::span<Vec3<double>>);
template void center_of_mass_jacobian(const Model&, Workspace<float>&, Numbers<float>,
                                      std::span<Vec3<float>>);
template void centroidal_momentum_matrix(const Model&, Workspace<double>&, Numbers<double>,
                                         std::span<Momentum<Hybrid, double>>);
template void centroidal_momentum_matrix(const Model&, Workspace<float>&, Numbers<float>,
                                         std::span<Momentum<Hybrid, float>>);
template void centroidal_momentum_matrix_rate(const Model&, Workspace<double>&, Numbers<double>,
                                              Numbers<double>, std::span<Wrench<Hybrid, double>>);
template void centroidal_momentum_matrix_rate(const Model&, Workspace<float>&, Numbers<float>, Numbers<float>,
                                              std::span<Wrench<Hybrid, float>>);

}  // namespace axode
