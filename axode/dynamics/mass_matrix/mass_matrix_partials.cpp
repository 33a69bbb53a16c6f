#include "axode/dynamics/mass_matrix/mass_matrix_partials.hpp"

#include <Eigen/Core>

#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/recursion/spatial_tree.hpp"

namespace axode {

template <class T>
void mass_matrix_partials(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                          std::type_identity_t<std::span<T>> dM) {
  Arena arena = checked<"mass_matrix_partials">(model, workspace, q, dM);
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  const Tree<T>& tree = model.tree<T>();
  const SpatialTree<T> s(arena, tree, q.data());
  for (T& x : dM) x = T(0);
  const auto add = [&](int k, int i, int j, const T& x) {
    const std::size_t c = static_cast<std::size_t>(k), a = static_cast<std::size_t>(i),
                      b = static_cast<std::size_t>(j);
    dM[(c * nv + a) * nv + b] += x;
    dM[(c * nv + b) * nv + a] += x;
  };
  // ∂M_ij/∂q_k is non-zero if bodies b_j < b_k are on the path of b_i, or if b_j <= b_i are on the path of
  // b_k. Quantities that velocity k displaces as a whole do not change.
  for (int b_i = 1; b_i <= tree->n; ++b_i)
    s.each_screw(b_i, [&](int i, const Twist<Spatial, T>& J_i) {
      const Momentum<Spatial, T> Pi = s.M[b_i] * J_i;
      for (int b_k = b_i; b_k > 0; b_k = tree->parent[b_k])
        s.each_screw(b_k, [&](int k, const Twist<Spatial, T>& J_k) {
          for (int b_j = tree->parent[b_k]; b_j > 0; b_j = tree->parent[b_j])
            s.each_screw(b_j, [&](int j, const Twist<Spatial, T>& J_j) { add(k, i, j, Pi | ad(J_j, J_k)); });
        });
    });
  for (int b_k = 1; b_k <= tree->n; ++b_k)
    s.each_screw(b_k, [&](int k, const Twist<Spatial, T>& J_k) {
      for (int b_i = tree->parent[b_k]; b_i > 0; b_i = tree->parent[b_i])
        s.each_screw(b_i, [&](int i, const Twist<Spatial, T>& J_i) {
          const Momentum<Spatial, T> Pi = s.M[b_k] * J_i, dPi = s.M[b_k] * ad(J_i, J_k);
          for (int b_j = b_i; b_j > 0; b_j = tree->parent[b_j])
            s.each_screw(b_j, [&](int j, const Twist<Spatial, T>& J_j) {
              const T x = (Pi | ad(J_j, J_k)) + (dPi | J_j);
              add(k, i, j, b_i == b_j ? T(0.5) * x : x);  // each pair of screws of one joint occurs twice
            });
        });
    });
}

template <class T>
Solvability inverse_mass_matrix_partials(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                         std::type_identity_t<std::span<T>> dM_inverse) {
  checked<"inverse_mass_matrix_partials">(model, workspace, q, dM_inverse);
  mass_matrix_partials(model, workspace, q, dM_inverse);
  const Eigen::Index nv = model.nv();
  Eigen::MatrixX<T> M_inverse(nv, nv);
  const std::span<T> entries(M_inverse.data(), static_cast<std::size_t>(M_inverse.size()));
  const Solvability verdict = inverse_mass_matrix<Hybrid>(model, workspace, q, entries);
  for (Eigen::Index k = 0; k < nv; ++k) {
    Eigen::Map<Eigen::MatrixX<T>> dM(dM_inverse.data() + k * nv * nv, nv, nv);
    dM = (-M_inverse * dM * M_inverse).eval();
  }
  return verdict;
}

template AXODE_ENTRY decltype(mass_matrix_partials<AXODE_T>) mass_matrix_partials<AXODE_T>;
template AXODE_ENTRY decltype(inverse_mass_matrix_partials<AXODE_T>) inverse_mass_matrix_partials<AXODE_T>;

}  // namespace axode
