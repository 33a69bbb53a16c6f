#include "axode/constraints/constrained_derivatives.hpp"

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/loop_system/independent_rows.hpp"
#include "axode/derivatives/inverse_dynamics_derivatives.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/decompositions.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

template <class T> using RowByRow = typename LoopSystem<T>::RowByRow;

template <class T> std::span<T> entries(RowByRow<T>& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}

/// The matrix of those rows of `all` whose indices are in `rows`.
template <class T> Eigen::MatrixX<T> rows_of(const RowByRow<T>& all, const std::vector<int>& rows) {
  Eigen::MatrixX<T> out(static_cast<Eigen::Index>(rows.size()), all.cols());
  for (std::size_t k = 0; k < rows.size(); ++k) out.row(static_cast<Eigen::Index>(k)) = all.row(rows[k]);
  return out;
}

template <class T> void write(const Eigen::MatrixX<T>& matrix, std::span<T> out) {
  if (!out.empty()) Eigen::Map<RowByRow<T>>(out.data(), matrix.rows(), matrix.cols()) = matrix;
}

}  // namespace

template <class T>
Solvability forward_dynamics_derivatives(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ClosedDynamicsDerivatives<T>>& d,
                                         const std::type_identity_t<Loads<T>>& loads) {
  using Matrix = Eigen::MatrixX<T>;
  using Vector = Eigen::VectorX<T>;
  catalog::check_motions<"forward_dynamics_derivatives">(model);
  LoopSystem<T>& system = checked(model, workspace, q, v);
  check_size("tau", tau.size(), v.size(), "nv");
  check_loads(model, loads);
  const Eigen::Index n = model.nv(), m = model.loops().rows;
  for (const std::span<T>& out : {d.a_q, d.a_v, d.a_tau})
    check_rows("d.a", out.size(), model.nv(), "nv * nv", model.nv());
  for (const std::span<T>& out : {d.lambda_q, d.lambda_v, d.lambda_tau})
    if (!out.empty()) check_rows("d.lambda", out.size(), model.loops().rows, "loops().rows * nv", model.nv());

  Vector a(n), h(n), gamma(m), lambda = Vector::Zero(m);
  const Solvability verdict =
      system.accelerate(q.data(), v.data(), tau.data(), loads, a.data(), lambda.data());
  const auto fail = [&](Solvability found) {
    for (const std::span<T>& out : {d.a_q, d.a_v, d.a_tau, d.lambda_q, d.lambda_v, d.lambda_tau})
      std::ranges::fill(out, std::numeric_limits<T>::quiet_NaN());
    return found;
  };
  if (!verdict.ok()) return fail(verdict);
  system.move(q.data(), v.data(), loads, h.data());
  system.bias(gamma.data());
  const IndependentRows<T> rows(system, ConstraintLevel::velocity);
  const Eigen::Index r = rows.rank();
  RowByRow<T> A(m, n), by_q(n, n), by_v(n, n), M(n, n);
  system.write(A.data());
  Workspace<T> tree(model, cut_tree);
  inverse_dynamics_derivatives(model, tree, q, v, std::span<const T>(a.data(), v.size()),
                               {entries<T>(by_q), entries<T>(by_v), entries<T>(M)}, loads);

  Matrix K = Matrix::Zero(n + r, n + r);
  const Matrix A_independent = rows_of<T>(A, rows.independent);
  K.topLeftCorner(n, n) = M;
  K.topRightCorner(n, r) = -A_independent.transpose();
  K.bottomLeftCorner(r, n) = A_independent;
  const LuFactor factor(K.template cast<double>());
  Vector right(n + r);
  for (Eigen::Index c = 0; c < n; ++c) right[c] = tau[static_cast<std::size_t>(c)] - h[c];
  for (Eigen::Index k = 0; k < r; ++k) right[n + k] = -gamma[rows.independent[static_cast<std::size_t>(k)]];
  const Vector found = factor.solve(right.template cast<double>()).template cast<T>();
  a = found.head(n);
  lambda.setZero();
  for (Eigen::Index k = 0; k < r; ++k) lambda[rows.independent[static_cast<std::size_t>(k)]] = found[n + k];

  RowByRow<T> forces_q = RowByRow<T>::Zero(n, n), rows_q = RowByRow<T>::Zero(m, n),
              rows_v = RowByRow<T>::Zero(m, n);
  system.force(q.data(), v.data(), a.data(), loads, h.data());
  system.make_rows(ConstraintLevel::velocity);
  system.differentiate(lambda.data(), rows_q.data(), rows_v.data(), forces_q.data());
  Matrix changes = Matrix::Zero(n + r, 3 * n);
  changes.topLeftCorner(n, n) = forces_q - by_q;
  changes.block(0, n, n, n) = -by_v;
  changes.topRightCorner(n, n).setIdentity();
  changes.bottomLeftCorner(r, n) = -rows_of<T>(rows_q, rows.independent);
  changes.block(n, n, r, n) = -rows_of<T>(rows_v, rows.independent);
  const Matrix x = factor.solve(changes.template cast<double>()).template cast<T>();
  Matrix lambda_rows = Matrix::Zero(m, 3 * n);
  for (Eigen::Index k = 0; k < r; ++k)
    lambda_rows.row(rows.independent[static_cast<std::size_t>(k)]) = x.row(n + k);
  write<T>(x.topLeftCorner(n, n), d.a_q);
  write<T>(x.block(0, n, n, n), d.a_v);
  write<T>(x.topRightCorner(n, n), d.a_tau);
  write<T>(lambda_rows.leftCols(n), d.lambda_q);
  write<T>(lambda_rows.middleCols(n, n), d.lambda_v);
  write<T>(lambda_rows.rightCols(n), d.lambda_tau);
  return x.allFinite() ? Solvability{} : fail({.not_finite = true});
}

namespace {

/// Computes the derivatives of the accelerations by q (index 0), v (1) and tau (2), nv × nv each.
template <class T> class Matrices {
 public:
  Matrices(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
           const Loads<T>& loads)
      : nv_(v.size()), entries_(3 * nv_ * nv_) {
    const std::span<T> all(entries_);
    const std::size_t n = nv_ * nv_;
    verdict = forward_dynamics_derivatives<T>(model, workspace, q, v, tau,
                                              {all.first(n), all.subspan(n, n), all.last(n)}, loads);
  }
  Eigen::Map<const RowByRow<T>> operator[](std::size_t k) const {
    const Eigen::Index n = static_cast<Eigen::Index>(nv_);
    return {entries_.data() + k * nv_ * nv_, n, n};
  }
  Solvability verdict;

 private:
  std::size_t nv_;
  std::vector<T> entries_;
};

}  // namespace

template <class T>
Solvability forward_dynamics_jvp(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> tau, Numbers<T> dq, Numbers<T> dv, Numbers<T> dtau,
                                 std::type_identity_t<std::span<T>> da,
                                 const std::type_identity_t<Loads<T>>& loads) {
  for (const auto& [name, size] :
       {std::pair("dq", dq.size()), {"dv", dv.size()}, {"dtau", dtau.size()}, {"da", da.size()}})
    check_size(name, size, static_cast<std::size_t>(model.nv()), "nv");
  const Matrices<T> d(model, workspace, q, v, tau, loads);
  as_eigen(da) = (d[0] * as_eigen<T>(dq) + d[1] * as_eigen<T>(dv) + d[2] * as_eigen<T>(dtau)).eval();
  return solved(d.verdict, model.nv(), da.data());
}

template <class T>
Solvability forward_dynamics_vjp(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> tau, Numbers<T> w,
                                 const std::type_identity_t<ForwardDynamicsGradients<T>>& gradient,
                                 const std::type_identity_t<Loads<T>>& loads) {
  check_size("w", w.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_results<T>(
      model,
      {{"gradient.q", gradient.q, 1}, {"gradient.v", gradient.v, 1}, {"gradient.tau", gradient.tau, 1}});
  const Matrices<T> d(model, workspace, q, v, tau, loads);
  const Eigen::VectorX<T> weights = as_eigen<T>(w);
  std::size_t k = 0;
  for (const std::span<T>& by : {gradient.q, gradient.v, gradient.tau})
    as_eigen(by) = d[k++].transpose() * weights;
  return solved(d.verdict, {gradient.q, gradient.v, gradient.tau});
}

template AXODE_ENTRY Solvability forward_dynamics_jvp(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>,
                                                      Numbers<AXODE_T>, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                                      Numbers<AXODE_T>, Numbers<AXODE_T>, std::span<AXODE_T>,
                                                      const Loads<AXODE_T>&);
template AXODE_ENTRY Solvability forward_dynamics_vjp(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>,
                                                      Numbers<AXODE_T>, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                                      const ForwardDynamicsGradients<AXODE_T>&,
                                                      const Loads<AXODE_T>&);
template AXODE_ENTRY Solvability forward_dynamics_derivatives(const Model&, LoopWorkspace<AXODE_T>&,
                                                              Numbers<AXODE_T>, Numbers<AXODE_T>,
                                                              Numbers<AXODE_T>,
                                                              const ClosedDynamicsDerivatives<AXODE_T>&,
                                                              const Loads<AXODE_T>&);

}  // namespace axode
