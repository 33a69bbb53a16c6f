#include "axode/constraints/local_mobility/closure_series.hpp"

#include "axode/eigen.hpp"

namespace axode::higher_order {
namespace {

using Series = Eigen::MatrixXd;  ///< 6 × monomials: a screw whose coordinates are polynomials

Screw<> screw_at(const double* x) { return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}}; }

/// Computes the Lie bracket of the terms of X of degree a and the terms of Z of degree k - a, multiplies it
/// by `scale`, and adds it to `out`. X, Z and `out` are power series of screws.
void add_bracket(const PolynomialRing& ring, const Series& X, const Series& Z, int a, int k, double scale,
                 Series& out) {
  for (int i = ring.begin(a); i < ring.begin(a + 1); ++i) {
    const Screw<> x = screw_at(X.data() + 6 * i);
    for (int j = ring.begin(k - a); j < ring.begin(k - a + 1); ++j)
      out.col(ring.product(i, j)) += scale * to_eigen(ad(x, screw_at(Z.data() + 6 * j)));
  }
}

/// Adds to `out` the part of degree k of the product p S, where the polynomial p has no constant.
void add_product(const PolynomialRing& ring, const Series& S, const Eigen::RowVectorXd& p, int k,
                 Series& out) {
  for (int a = 1; a <= k; ++a)
    for (int i = ring.begin(a); i < ring.begin(a + 1); ++i) {
      if (p[i] == 0) continue;
      for (int j = ring.begin(k - a); j < ring.begin(k - a + 1); ++j)
        out.col(ring.product(i, j)) += p[i] * S.col(j);
    }
}

/// The first `count` coefficients of dexp as a power series of ad, 1/(k + 1)!, or of its inverse.
std::vector<double> dexp_coefficients(int count, bool inverse) {
  std::vector<double> c(static_cast<std::size_t>(count)), factorial(c.size() + 1, 1);
  for (std::size_t k = 1; k < factorial.size(); ++k) factorial[k] = factorial[k - 1] * static_cast<double>(k);
  for (std::size_t n = 0; n < c.size(); ++n) {
    if (!inverse) {
      c[n] = 1 / factorial[n + 1];
      continue;
    }
    c[n] = n == 0 ? 1 : 0;
    for (std::size_t k = 0; k < n; ++k) c[n] -= c[k] / factorial[n + 1 - k];
  }
  return c;
}

/// Multiplies the part of degree k of each polynomial by k. This is the derivative t d/dt along rays x = t u.
Eigen::MatrixXd along_rays(const PolynomialRing& ring, const Eigen::Ref<const Eigen::MatrixXd>& p) {
  Eigen::MatrixXd out = p;
  for (int i = 0; i < ring.size(); ++i) out.col(i) *= ring.degree_of(i);
  return out;
}

/// Adds dexp_X W to V up to a degree, where X and W have no constant (D13.4).
void add_dexp(const PolynomialRing& ring, const Series& X, Series W, int degree, Series& V) {
  const std::vector<double> c = dexp_coefficients(degree, false);
  V += W;
  for (std::size_t b = 1; b < c.size(); ++b) {
    Series next = ring.zero(6);
    for (int k = 2; k <= degree; ++k)
      for (int a = 1; a < k; ++a) add_bracket(ring, X, W, a, k, 1, next);
    W = std::move(next);
    V += c[b] * W;
  }
}

/// Passes one joint on the way around a loop: adds the twist of the joint to V, the twist of the body before
/// the joint relative to the first body. Both are power series (D13.3, D13.4).
void pass(const PolynomialRing& ring, const PassedJoint& joint, const Eigen::Ref<const Eigen::MatrixXd>& x,
          const Eigen::MatrixXd& dx, int degree, Series& V) {
  const std::size_t n = joint.S.size();
  Series X = ring.zero(6), W = ring.zero(6);
  for (std::size_t m = 0; m < n; ++m) {
    Series S = ring.zero(6);
    S.col(0) = to_eigen(joint.S[m]);
    for (int k = 1; k < degree; ++k) {
      for (int a = 1; a <= k; ++a) add_bracket(ring, V, S, a, k, 1, S);
      S.middleCols(ring.begin(k), ring.count(k)) /= k;
    }
    for (int k = 1; k <= degree; ++k) {
      add_product(ring, S, dx.row(joint.coordinates[m]), k, W);
      if (n > 1) add_product(ring, S, x.row(joint.coordinates[m]), k, X);
    }
  }
  if (n > 1) {
    add_dexp(ring, X, std::move(W), degree, V);
  } else {
    V += W;
  }
}

}  // namespace

Eigen::MatrixXd twist_series(const PolynomialRing& ring, const std::vector<PassedJoint>& loop,
                             const Eigen::Ref<const Eigen::MatrixXd>& x, int degree) {
  const Eigen::MatrixXd dx = along_rays(ring, x);
  Series V = ring.zero(6);
  for (const PassedJoint& joint : loop) pass(ring, joint, x, dx, degree, V);
  return V;
}

Eigen::MatrixXd logarithm_series(const PolynomialRing& ring, const Eigen::MatrixXd& V, int degree) {
  const std::vector<double> c = dexp_coefficients(degree, true);
  std::vector<Series> terms(c.size(), ring.zero(6));  // ad_φ^b V
  terms[0] = V;
  Series phi = ring.zero(6);
  for (int k = 1; k <= degree; ++k) {
    const int first = ring.begin(k), count = ring.count(k);
    Series sum = V.middleCols(first, count);
    for (int b = 1; b < k; ++b) {
      const auto m = static_cast<std::size_t>(b);
      for (int a = 1; a <= k - b; ++a) add_bracket(ring, phi, terms[m - 1], a, k, 1, terms[m]);
      sum += c[m] * terms[m].middleCols(first, count);
    }
    phi.middleCols(first, count) = sum / k;
  }
  return phi;
}

}  // namespace axode::higher_order
