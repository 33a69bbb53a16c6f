#include "axode/constraints/local_mobility/elimination.hpp"

#include <algorithm>

namespace axode::higher_order {

int rank_of(const SingularValues& svd) {
  const double largest = svd.s.size() > 0 ? svd.s[0] : 0;
  return svd.rank(rank_tolerance * std::max(1.0, largest));
}

Elimination eliminate(PolynomialRings& rings, const Equations& phi, const Eigen::MatrixXd& A, int K) {
  const SingularValues svd = singular_values(A);
  Elimination out;
  out.singular_values = svd.s;
  out.rank = rank_of(svd);
  const Eigen::Index d = A.cols() - out.rank;
  if (d == 0) return out;
  const PolynomialRing& ring = rings.at(static_cast<int>(d), K);
  out.ring = &ring;
  out.z = ring.linear(svd.V.rightCols(d));
  const Eigen::MatrixXd pseudo_inverse = svd.V.leftCols(out.rank) *
                                         svd.s.head(out.rank).cwiseInverse().asDiagonal() *
                                         svd.U.leftCols(out.rank).transpose();
  if (out.rank > 0)
    for (int k = 2; k <= K; ++k) {
      rings.ask();
      const Eigen::MatrixXd r = phi(ring, out.z, k);
      out.z.middleCols(ring.begin(k), ring.count(k)) -=
          pseudo_inverse * r.middleCols(ring.begin(k), ring.count(k));
    }
  out.left = svd.U.rightCols(A.rows() - out.rank);
  out.g = ring.zero(out.left.cols());
  if (out.left.cols() > 0) out.g = out.left.transpose() * phi(ring, out.z, K);
  out.g.leftCols(ring.begin(std::min(2, K + 1))).setZero();
  double largest_yet = 1;
  for (int k = 0; k <= K; ++k) {
    for (const Eigen::MatrixXd* p : {&out.z, &out.g})
      if (p->rows() > 0)
        largest_yet =
            std::max(largest_yet, p->middleCols(ring.begin(k), ring.count(k)).cwiseAbs().maxCoeff());
    out.scale.push_back(largest_yet);
  }
  return out;
}

std::vector<Form> independent_forms(const PolynomialRing& ring, const Eigen::MatrixXd& g,
                                    const std::vector<double>& scale) {
  std::vector<Form> out;
  Eigen::MatrixXd rest = g, combination = Eigen::MatrixXd::Identity(g.rows(), g.rows());
  for (int k = 1; k <= ring.degree() && rest.rows() > 0; ++k) {
    const SingularValues svd = singular_values(rest.middleCols(ring.begin(k), ring.count(k)));
    const int rank = svd.rank(rank_tolerance * scale[static_cast<std::size_t>(k)]);
    const Eigen::MatrixXd mixed = svd.U.transpose() * rest;
    combination *= svd.U;
    for (int c = 0; c < rank; ++c) {
      out.push_back({k, mixed.row(c) / svd.s[c], combination.col(c) / svd.s[c]});
      out.back().p.head(ring.begin(k)).setZero();
    }
    rest = mixed.bottomRows(mixed.rows() - rank);
    combination = Eigen::MatrixXd(combination.rightCols(rest.rows()));
    rest.leftCols(ring.begin(k + 1)).setZero();
  }
  return out;
}

}  // namespace axode::higher_order
