#include "axode/dynamics/closed_form/coriolis.hpp"

#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

template <class T> Wrench<Spatial, T> per_second(const Momentum<Spatial, T>& Pi) { return {Pi.l, Pi.p}; }

/// The 6 × 6 matrix B of one body with the spatial inertia M, the spatial twist V and the spatial Jacobian J
/// in the Coriolis matrix C, which is the sum of Jᵀ (M J' + B J) over all bodies. For a twist X, B X is
///   -ad_Vᵀ M X - M ad_V X                      for CoriolisForm::paper,
///   -ad_Vᵀ M X                                 for `skew` and `spatial`, which are equal,
///   (-ad_Vᵀ M X - M ad_V X - ad_Xᵀ M V) / 2    for `christoffel`.
template <class T>
TwistToWrench<Spatial, T> body_term(CoriolisForm form, const Inertia<T>& M, const Twist<Spatial, T>& V) {
  switch (form) {
    case CoriolisForm::paper:
      return TwistToWrench<Spatial, T>::of(
          [&](const auto& X) { return coad(V, M * X) - per_second(M * ad(V, X)); });
    case CoriolisForm::christoffel:
      return TwistToWrench<Spatial, T>::of([&](const auto& X) {
        return T(0.5) * (coad(V, M * X) - per_second(M * ad(V, X)) + coad(X, M * V));
      });
    case CoriolisForm::skew:
    case CoriolisForm::spatial: break;
  }
  return TwistToWrench<Spatial, T>::of([&](const auto& X) { return coad(V, M * X); });
}

}  // namespace

template <class T>
void coriolis_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                     CoriolisForm form, std::type_identity_t<std::span<T>> C) {
  Arena arena = checked<"coriolis_matrix">(model, workspace, q, v, C);
  const Tree<T>& tree = model.tree<T>();
  CoriolisBodies<T> bodies(arena);
  bodies.spatial.run(tree, q.data());
  const SpatialTree<T>& s = bodies.spatial;  // a capture of a structured binding is not for every compiler
  const auto V = bodies.V;
  const auto B = bodies.B;
  s.twists(v.data(), V);
  B[0] = {};
  for (int i = 1; i <= tree->n; ++i) B[i] = body_term(form, s.M_body[i], V[i]);
  for (int i = tree->n; i > 0; --i) B[tree->parent[i]] += B[i];

  const std::size_t nv = static_cast<std::size_t>(tree->nv);
  const auto at = [&](int r, int c) -> T& {
    return C[static_cast<std::size_t>(r) * nv + static_cast<std::size_t>(c)];
  };
  for (T& x : C) x = T(0);
  for (int i = tree->n; i > 0; --i)
    s.each_screw(i, [&](int c, const Twist<Spatial, T>& J) {
      const Momentum<Spatial, T> Pi = s.M[i] * J;
      const Wrench<Spatial, T> of_column = per_second(s.M[i] * ad(V[i], J)) + B[i] * J;
      const Wrench<Spatial, T> of_row = B[i].transposed_times(J);
      s.each_screw(i, [&](int r, const Twist<Spatial, T>& J_r) { at(r, c) += of_column | J_r; });
      for (int j = tree->parent[i]; j > 0; j = tree->parent[j])
        s.each_screw(j, [&](int r, const Twist<Spatial, T>& J_r) {
          at(r, c) += of_column | J_r;
          at(c, r) += (Pi | ad(V[j], J_r)) + (of_row | J_r);
        });
    });
}

template <class T>
void christoffel(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                 std::type_identity_t<std::span<T>> Gamma) {
  Arena arena = checked<"christoffel">(model, workspace, q, Gamma);
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  const Tree<T>& tree = model.tree<T>();
  const SpatialTree<T> s(arena, tree, q.data());
  for (T& x : Gamma) x = T(0);
  const auto each_on_path = [&](int from, const auto& f) {
    for (int i = from; i > 0; i = tree->parent[i])
      s.each_screw(i, [&](int c, const Twist<Spatial, T>& J) { f(i, c, J); });
  };
  for (int m = 1; m <= tree->n; ++m)  // m is the outermost of the three bodies
    each_on_path(m, [&](int b_i, int i, const Twist<Spatial, T>& J_i) {
      const Momentum<Spatial, T> Pi = s.M[m] * J_i;
      each_on_path(m, [&](int b_j, int j, const Twist<Spatial, T>& J_j) {
        const Momentum<Spatial, T> Pi_j = s.M[m] * J_j, Pi_ij = s.M[m] * ad(J_i, J_j);
        const auto add = [&](int b_k, int k, const Twist<Spatial, T>& J_k) {
          const T inner_to_outer = b_k <= b_j ? Pi | ad(J_k, J_j) : Pi | ad(J_j, J_k);
          const std::size_t at = (static_cast<std::size_t>(i) * nv + static_cast<std::size_t>(j)) * nv;
          Gamma[at + static_cast<std::size_t>(k)] +=
              T(0.5) * ((Pi_ij | J_k) + (Pi_j | ad(J_i, J_k)) + inner_to_outer);
        };
        if (b_i == m || b_j == m)
          each_on_path(m, add);
        else
          s.each_screw(m, [&](int k, const Twist<Spatial, T>& J_k) { add(m, k, J_k); });
      });
    });
}

template AXODE_ENTRY decltype(coriolis_matrix<AXODE_T>) coriolis_matrix<AXODE_T>;
template AXODE_ENTRY decltype(christoffel<AXODE_T>) christoffel<AXODE_T>;

}  // namespace axode
