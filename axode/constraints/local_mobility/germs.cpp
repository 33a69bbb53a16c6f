#include "axode/constraints/local_mobility/germs.hpp"

#include <algorithm>
#include <random>

#include "axode/constraints/local_mobility/directions.hpp"
#include "axode/recursion/decompositions.hpp"

namespace axode::higher_order {
namespace {

constexpr int deepest = 6;

/// A blow-up: the substitution u = s (e + B v) for the unknowns u, as polynomials of (s, v). s is the
/// distance along the direction e, and v the deviation from it in the orthonormal basis B of directions
/// orthogonal to e.
struct BlowUp {
  BlowUp(const PolynomialRing& ring, const Eigen::VectorXd& direction)
      : e(direction), B(orthogonal_complement(e.transpose()).transpose()) {
    const Eigen::Index d = e.size();
    u = of(ring, ring.linear(Eigen::MatrixXd::Identity(d, d)));
  }
  /// Computes s (e + B v) for polynomials y = (s, v).
  Eigen::MatrixXd of(const PolynomialRing& ring, const Eigen::MatrixXd& y) const {
    return e * y.row(0) + B * ring.times(y.bottomRows(y.rows() - 1), y.row(0));
  }

  Eigen::VectorXd e;
  Eigen::MatrixXd B, u;
};

/// Substitutes u = s (e + B v) in the equations g(u) = 0, where s is the distance along a direction e, the
/// columns of B are an orthonormal basis of the directions orthogonal to e, and v are the coordinates of the
/// deviation from e in this basis. Divides each equation by the power of s that its terms have in common: h_i
/// = g_i(s (e + B v)) / s^(m_i) for an equation whose lowest degree is m_i (D13.11). Terms of the results
/// whose degree is above the largest degree of the ring of polynomials `small` are dropped.
Eigen::MatrixXd divided(const PolynomialRing& ring, const std::vector<Form>& rows, const BlowUp& blow,
                        const PolynomialRing& small) {
  Eigen::MatrixXd g(static_cast<Eigen::Index>(rows.size()), ring.size());
  for (std::size_t c = 0; c < rows.size(); ++c) g.row(static_cast<Eigen::Index>(c)) = rows[c].p;
  const Eigen::MatrixXd G = ring.substitute(g, ring, blow.u);
  Eigen::MatrixXd h = small.zero(g.rows());
  std::vector<int> exponents(static_cast<std::size_t>(small.variables()));
  for (int i = 1; i < small.size(); ++i)
    for (std::size_t c = 0; c < rows.size(); ++c) {
      for (int k = 0; k < small.variables(); ++k)
        exponents[static_cast<std::size_t>(k)] = small.exponent(i, k) + (k == 0 ? rows[c].degree : 0);
      const auto row = static_cast<Eigen::Index>(c);
      h(row, i) = G(row, ring.monomial(exponents));
    }
  return h;
}

/// The power series at 0 of the solutions of equations with the derivative A at 0, up to degree K.
std::vector<Germ> solve(PolynomialRings& rings, const Equations& equations, const Eigen::MatrixXd& A, int K,
                        int depth) {
  const Elimination left = eliminate(rings, equations, A, K);
  if (!left.ring) return {};
  std::vector<Germ> found = germs(rings, *left.ring, left.g, left.scale, depth + 1);
  for (Germ& germ : found) germ.z = left.ring->substitute(left.z, *germ.ring, germ.z);
  return found;
}

/// Computes the power series, at s = 0 and v = 0, of the solutions of h(s, v) = 0 along which ∂h/∂v is
/// singular (multiple solutions). These also solve the larger system h = 0, (∂h/∂v) λ = 0 with a kernel
/// vector λ as additional unknown. λ varies along a solution; its projection on the kernel of ∂h/∂v at s = 0,
/// v = 0 is held constant (D13.12). The equations h = 0 are the result of a blow-up: u = s (e + B v) was
/// substituted for unknowns u, with the distance s along a direction e and the coordinates v in the basis B
/// of the directions orthogonal to e.
std::vector<Germ> deflated(PolynomialRings& rings, const PolynomialRing& ring, const Eigen::MatrixXd& h,
                           int depth) {
  const int d = ring.variables(), K = ring.degree() - 1;
  const SingularValues svd = singular_values(h.middleCols(2, d - 1));
  const int rank = svd.rank(rank_tolerance);
  const Eigen::MatrixXd kernel = svd.V.rightCols(d - 1 - rank), rest = svd.V.leftCols(rank);
  if (kernel.cols() == 0) return {};
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  Eigen::VectorXd mix(kernel.cols());
  for (double& entry : mix) entry = normal(random);
  const Eigen::VectorXd lambda_0 = kernel * mix.normalized();

  const PolynomialRing& low = rings.at(d, K);
  std::vector<Eigen::MatrixXd> by_v;
  for (int k = 1; k < d; ++k) by_v.push_back(ring.derivative(h, k).leftCols(low.size()));
  const Eigen::MatrixXd value = h.leftCols(low.size());
  const Eigen::Index m = h.rows();
  const Equations equations = [&](const PolynomialRing& in, const Eigen::MatrixXd& w, int) {
    const Eigen::MatrixXd z = w.topRows(d);
    Eigen::MatrixXd lambda = rest * w.bottomRows(rank), out(2 * m, in.size());
    lambda.col(0) += lambda_0;
    out.topRows(m) = low.substitute(value, in, z);
    out.bottomRows(m).setZero();
    for (int k = 1; k < d; ++k)
      out.bottomRows(m) +=
          in.times(low.substitute(by_v[static_cast<std::size_t>(k - 1)], in, z), lambda.row(k - 1));
    return out;
  };
  const int unknowns = d + rank;
  const PolynomialRing& first = rings.at(unknowns, 1);
  const Eigen::MatrixXd linear =
      equations(first, first.linear(Eigen::MatrixXd::Identity(unknowns, unknowns)), 1);
  if (linear.col(0).norm() > coefficient_tolerance) return {};
  std::vector<Germ> found = solve(rings, equations, linear.rightCols(unknowns), K, depth);
  std::erase_if(found, [](const Germ& germ) { return !germ.settled; });
  for (Germ& germ : found) {
    germ.z = Eigen::MatrixXd(germ.z.topRows(d));
    germ.multiple = true;
  }
  return found;
}

/// The germs of solutions, in the unknowns u of the rows, that leave u = 0 in the direction e.
std::vector<Germ> blown_up(PolynomialRings& rings, const PolynomialRing& ring, const std::vector<Form>& rows,
                           const Eigen::VectorXd& e, int K, int depth) {
  const BlowUp blow(ring, e);
  const PolynomialRing& small = rings.at(ring.variables(), K);
  const Eigen::MatrixXd h = divided(ring, rows, blow, small);
  const Equations equations = [&](const PolynomialRing& in, const Eigen::MatrixXd& y, int) {
    return small.substitute(h, in, y);
  };
  std::vector<Germ> found = solve(rings, equations, h.middleCols(1, ring.variables()), K, depth);
  if (K > 1 && std::ranges::any_of(found, [](const Germ& germ) { return !germ.settled; }))
    if (std::vector<Germ> multiple = deflated(rings, small, h, depth); !multiple.empty())
      found = std::move(multiple);
  // A germ within s = 0 is the single point u = 0.
  std::erase_if(found,
                [](const Germ& germ) { return germ.z.row(0).cwiseAbs().maxCoeff() < coefficient_tolerance; });
  for (Germ& germ : found) germ.z = blow.of(*germ.ring, germ.z);
  return found;
}

}  // namespace

std::vector<Germ> germs(PolynomialRings& rings, const PolynomialRing& ring, const Eigen::MatrixXd& g,
                        const std::vector<double>& scale, int depth) {
  constexpr int enough = 3;  // number of orders in which a further equation would have appeared
  const int d = ring.variables();
  const std::vector<Form> rows = independent_forms(ring, g, scale);
  if (rows.empty())
    return {{&ring, ring.linear(Eigen::MatrixXd::Identity(d, d)), g.rows() == 0 || ring.degree() >= enough,
             false}};
  if (d == 1) return {};
  int K = ring.degree();
  for (const Form& row : rows) K = std::min(K, ring.degree() - row.degree);
  std::vector<Germ> out;
  for (const Direction& direction : common_zeros(rings, ring, rows)) {
    if (K < 1 || depth > deepest) {
      const PolynomialRing& line = rings.at(1, 1);
      out.push_back({&line, line.linear(direction.e), false, false});
      continue;
    }
    for (Germ& germ : blown_up(rings, ring, rows, direction.e, K, depth)) out.push_back(std::move(germ));
  }
  return out;
}

}  // namespace axode::higher_order
