#include "axode/kinematics/center_of_mass.hpp"

#include "axode/kinematics/checked.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/kinematics/scratch.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// The centre of mass of all moving bodies, in the frame in which their poses C are given. Throws
/// std::domain_error if they have no mass.
template <class T> Vec3<T> mass_center(const Model& model, const Tree<T>& tree, const BodyPoses<T>& C) {
  T m(0);
  Vec3<T> h;
  for (int i = 1; i <= tree->n; ++i) {
    m += tree.M[i].m;
    h += tree.M[i].m * C[i].r + C[i].R * tree.M[i].h;
  }
  if (!(m > T(0))) throw no_mass(model);
  return (T(1) / m) * h;
}

/// Computes the poses C of all bodies relative to the centre of mass of the whole system, in inertial axes,
/// and the inertias M of their subtrees there; entry 0 of M is the inertia of all bodies.
template <class T> void compose(const Model& model, const Tree<T>& tree, const T* q, SubtreeInertias<T>& at) {
  at.C.run(tree, q);
  const Vec3<T> c = mass_center(model, tree, at.C);
  for (int i = 1; i <= tree->n; ++i) {
    at.C[i].r -= c;
    at.M[i] = transform(at.C[i], tree.M[i]);
  }
  at.M[0] = {};
  for (int i = tree->n; i > 0; --i) at.M[tree->parent[i]] += at.M[i];
}

}  // namespace

template <class T> Vec3<T> center_of_mass(const Model& model, Workspace<T>& workspace, Numbers<T> q) {
  Arena arena = checked<"center_of_mass">(model, workspace, q);
  return mass_center(model, model.tree<T>(), BodyPoses<T>(arena, model.tree<T>(), q.data()));
}

template <class T>
void center_of_mass_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             std::type_identity_t<std::span<Vec3<T>>> J) {
  Arena arena = checked<"center_of_mass_jacobian">(model, workspace, q, J);
  const Tree<T>& tree = model.tree<T>();
  SubtreeInertias<T> at(arena);
  compose(model, tree, q.data(), at);
  for (Vec3<T>& column : J) column = {};
  for (int i = 1; i <= tree->n; ++i)
    each_screw(tree, i, at.C[i], [&](int c, const Screw<T>& X) {
      J[c] += (T(1) / at.M[0].m) *
              (at.M[i] * twist<Spatial>(X)).p;  // momentum of the subtree for a unit velocity
    });
}

template <class T>
void centroidal_momentum_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<Momentum<Hybrid, T>>> A) {
  Arena arena = checked<"centroidal_momentum_matrix">(model, workspace, q, A);
  const Tree<T>& tree = model.tree<T>();
  SubtreeInertias<T> at(arena);
  compose(model, tree, q.data(), at);
  for (Momentum<Hybrid, T>& column : A) column = {};
  for (int i = 1; i <= tree->n; ++i)
    each_screw(tree, i, at.C[i], [&](int c, const Screw<T>& X) {
      const Momentum<Spatial, T> Pi = at.M[i] * twist<Spatial>(X);
      A[c] += Momentum<Hybrid, T>{Pi.l, Pi.p};
    });
}

template <class T>
void centroidal_momentum_matrix_rate(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     std::type_identity_t<std::span<Wrench<Hybrid, T>>> dA) {
  Arena arena = checked<"centroidal_momentum_matrix_rate">(model, workspace, q, v, dA);
  const Tree<T>& tree = model.tree<T>();
  SubtreeInertias<T> at(arena);
  compose(model, tree, q.data(), at);
  at.V[0] = {};
  at.dM[0] = {};
  for (int i = 1; i <= tree->n; ++i) {
    at.V[i] = at.V[tree->parent[i]];
    each_screw(tree, i, at.C[i], [&](int c, const Screw<T>& X) { at.V[i] += v[c] * twist<Spatial>(X); });
    at.dM[i] = inertia_rate(at.V[i], transform(at.C[i], tree.M[i]));
  }
  for (int i = tree->n; i > 0; --i) at.dM[tree->parent[i]] += at.dM[i];
  const Vec3<T> dc =
      (T(1) / at.M[0].m) * at.dM[0].h;  // velocity of the centre of mass, about which moments are taken
  for (Wrench<Hybrid, T>& column : dA) column = {};
  for (int i = 1; i <= tree->n; ++i)
    each_screw(tree, i, at.C[i], [&](int c, const Screw<T>& X) {
      const Twist<Spatial, T> J = twist<Spatial>(X), dJ = ad(at.V[i], J);
      const Momentum<Spatial, T> Pi = at.M[i] * J, dPi = at.dM[i] * J + at.M[i] * dJ;
      dA[c] += Wrench<Hybrid, T>{dPi.l - cross(dc, Pi.p), dPi.p};
    });
}

template AXODE_ENTRY Vec3<AXODE_T> center_of_mass(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>);
template AXODE_ENTRY decltype(center_of_mass_jacobian<AXODE_T>) center_of_mass_jacobian<AXODE_T>;
template AXODE_ENTRY decltype(centroidal_momentum_matrix<AXODE_T>) centroidal_momentum_matrix<AXODE_T>;
template AXODE_ENTRY decltype(centroidal_momentum_matrix_rate<AXODE_T>)
    centroidal_momentum_matrix_rate<AXODE_T>;

}  // namespace axode
