#include "axode/dynamics/mass_matrix.hpp"

#include <Eigen/Core>
#include <algorithm>

#include "axode/dynamics/sparse_factor.hpp"
#include "axode/dynamics/spatial_tree.hpp"
#include "axode/kinematics/check_arguments.hpp"

namespace axode {

template <class T>
void mass_matrix_partials(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                          std::type_identity_t<std::span<T>> dM) {
  check_state(model, workspace, q);
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  check_size("dM", dM.size(), nv * nv * nv, "nv * nv * nv");
  const Tree<T>& tree = model.tree<T>();
  const SpatialTree<T> s(tree, workspace, q.data());
  for (T& x : dM) x = T(0);
  const auto add = [&](int k, int i, int j, const T& x) {
    const std::size_t c = static_cast<std::size_t>(k), a = static_cast<std::size_t>(i),
                      b = static_cast<std::size_t>(j);
    dM[(c * nv + a) * nv + b] += x;
    dM[(c * nv + b) * nv + a] += x;
  };
  // Bodies b_j < b_k on the path of b_i, or b_j <= b_i on the path of b_k; what moves along with k changes
  // nothing.
  for (int b_i = 1; b_i <= tree.n; ++b_i)
    s.each_screw(b_i, [&](int i, const Twist<Spatial, T>& J_i) {
      const Momentum<Spatial, T> Pi = s.M[b_i] * J_i;
      for (int b_k = b_i; b_k > 0; b_k = tree.parent[b_k])
        s.each_screw(b_k, [&](int k, const Twist<Spatial, T>& J_k) {
          for (int b_j = tree.parent[b_k]; b_j > 0; b_j = tree.parent[b_j])
            s.each_screw(b_j, [&](int j, const Twist<Spatial, T>& J_j) { add(k, i, j, Pi | ad(J_j, J_k)); });
        });
    });
  for (int b_k = 1; b_k <= tree.n; ++b_k)
    s.each_screw(b_k, [&](int k, const Twist<Spatial, T>& J_k) {
      for (int b_i = tree.parent[b_k]; b_i > 0; b_i = tree.parent[b_i])
        s.each_screw(b_i, [&](int i, const Twist<Spatial, T>& J_i) {
          const Momentum<Spatial, T> Pi = s.M[b_k] * J_i, dPi = s.M[b_k] * ad(J_i, J_k);
          for (int b_j = b_i; b_j > 0; b_j = tree.parent[b_j])
            s.each_screw(b_j, [&](int j, const Twist<Spatial, T>& J_j) {
              const T x = (Pi | ad(J_j, J_k)) + (dPi | J_j);
              add(k, i, j, b_i == b_j ? T(0.5) * x : x);  // each pair of one joint comes twice
            });
        });
    });
}

Solvability inverse_mass_matrix_partials(const Model& model, Workspace<double>& workspace,
                                         std::span<const double> q, std::span<double> dM_inverse) {
  mass_matrix_partials(model, workspace, q, dM_inverse);
  const Eigen::Index nv = model.nv();
  Eigen::MatrixXd M_inverse(nv, nv);
  const std::span<double> entries(M_inverse.data(), static_cast<std::size_t>(M_inverse.size()));
  const Solvability solvability = inverse_mass_matrix<Spatial>(model, workspace, q, entries);
  for (Eigen::Index k = 0; k < nv; ++k) {
    Eigen::Map<Eigen::MatrixXd> dM(dM_inverse.data() + k * nv * nv, nv, nv);
    dM = (-M_inverse * dM * M_inverse).eval();
  }
  return solvability;
}

template <class T>
MassMatrixFactor<T>::MassMatrixFactor(const Model& model)
    : model_(model),
      nv_(model.nv()),
      H_(static_cast<std::size_t>(model.nv()) * static_cast<std::size_t>(model.nv())) {}

template <class T> Solvability MassMatrixFactor<T>::factorize(std::type_identity_t<std::span<const T>> M) {
  check_square("M", M.size(), model_);
  std::copy(M.begin(), M.end(), H_.begin());
  const int c = axode::factorize(model_.tree<T>(), H_.data());
  return {c < 0 ? 0 : body_of_velocity(model_.tree<T>(), c)};
}

template <class T> void MassMatrixFactor<T>::solve(std::type_identity_t<std::span<T>> x) const {
  check_size("x", x.size(), static_cast<std::size_t>(nv_), "nv");
  axode::solve(model_.tree<T>(), H_.data(), x.data());
}

template <class T> void MassMatrixFactor<T>::inverse(std::type_identity_t<std::span<T>> M_inverse) const {
  check_square("M_inverse", M_inverse.size(), model_);
  const std::size_t nv = static_cast<std::size_t>(nv_);
  std::fill(M_inverse.begin(), M_inverse.end(), T(0));
  for (std::size_t c = 0; c < nv; ++c) {
    M_inverse[c * nv + c] = T(1);
    solve(M_inverse.subspan(c * nv, nv));
  }
}

template class MassMatrixFactor<double>;
template class MassMatrixFactor<float>;
template void mass_matrix_partials(const Model&, Workspace<double>&, Numbers<double>, std::span<double>);
template void mass_matrix_partials(const Model&, Workspace<float>&, Numbers<float>, std::span<float>);

}  // namespace axode
