#include "axode/constraints/local_mobility/directions.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>
#include <random>

#include "axode/recursion/decompositions.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode::higher_order {
namespace {

using Complex = std::complex<double>;

constexpr double same_root = 1e-3;       // roots that rounding has separated from a multiple root are closer
                                         // than this
constexpr double same_direction = 1e-4;  // two directions that a search has found are the same if they are
                                         // closer than this

/// The one of the vectors x and -x whose first entry that is not 0 is positive.
Eigen::VectorXd on_half_sphere(const Eigen::VectorXd& x) {
  for (const double entry : x)
    if (std::abs(entry) > coefficient_tolerance) return entry > 0 ? x : Eigen::VectorXd(-x);
  return x;
}

/// The leading forms (terms of lowest degree) of polynomial equations, one in each row, divided by its norm.
Eigen::MatrixXd leading_forms(const PolynomialRing& ring, const std::vector<Form>& rows) {
  int highest = 0;
  for (const Form& row : rows) highest = std::max(highest, row.degree);
  Eigen::MatrixXd F = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), ring.begin(highest + 1));
  for (std::size_t c = 0; c < rows.size(); ++c) {
    const int first = ring.begin(rows[c].degree), count = ring.count(rows[c].degree);
    F.row(static_cast<Eigen::Index>(c)).segment(first, count) = rows[c].p.segment(first, count).normalized();
  }
  return F;
}

/// The distinct roots of a polynomial with coefficients c, highest power first. Roots that rounding has
/// separated from a multiple root are replaced by their mean.
std::vector<Complex> distinct_roots(const Eigen::VectorXd& c) {
  Eigen::Index first = 0;
  while (first < c.size() && std::abs(c[first]) < 1e-14 * c.cwiseAbs().maxCoeff()) ++first;
  if (first == c.size()) return {};
  std::vector<std::vector<Complex>> groups;
  for (const Complex& root : polynomial_roots(c.tail(c.size() - first))) {
    const auto near = std::ranges::find_if(groups, [&](const std::vector<Complex>& group) {
      return std::abs(group[0] - root) < same_root * (1 + std::abs(root));
    });
    if (near == groups.end()) {
      groups.push_back({root});
    } else {
      near->push_back(root);
    }
  }
  std::vector<Complex> out;
  for (const std::vector<Complex>& group : groups) {
    Complex sum = 0;
    for (const Complex& root : group) sum += root;
    out.push_back(sum / static_cast<double>(group.size()));
  }
  return out;
}

/// The directions (x, y) of the real zeros of a binary form c_0 x^m + c_1 x^(m-1) y + ... + c_m y^m.
std::vector<Eigen::VectorXd> zeros_of_binary_form(const Eigen::VectorXd& c) {
  const double angle = 0.7393, cosine = std::cos(angle), sine = std::sin(angle);
  const Eigen::Index m = c.size() - 1;
  // x = cosine t - sine, y = sine t + cosine: the form as a polynomial in t, the highest power first.
  const auto product = [](const Eigen::VectorXd& a, double high, double low) {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(a.size() + 1);
    out.head(a.size()) += high * a;
    out.tail(a.size()) += low * a;
    return out;
  };
  Eigen::VectorXd turned = Eigen::VectorXd::Zero(m + 1);
  for (Eigen::Index k = 0; k <= m; ++k) {
    Eigen::VectorXd term = Eigen::VectorXd::Ones(1);
    for (Eigen::Index l = 0; l < m; ++l)
      term = l < k ? product(term, sine, cosine) : product(term, cosine, -sine);
    turned += c[k] * term;
  }
  std::vector<Eigen::VectorXd> out;
  for (const Complex& root : distinct_roots(turned)) {
    if (std::abs(root.imag()) > coefficient_tolerance * (1 + std::abs(root))) continue;
    const double t = root.real();
    out.push_back(on_half_sphere(Eigen::Vector2d(cosine * t - sine, sine * t + cosine).normalized()));
  }
  return out;
}

std::vector<Direction> binary_zeros(const PolynomialRing& ring, const std::vector<Form>& rows) {
  std::optional<std::vector<Eigen::VectorXd>> common;
  for (const Form& row : rows) {
    const Eigen::VectorXd c = row.p.segment(ring.begin(row.degree), ring.count(row.degree)).transpose();
    const std::vector<Eigen::VectorXd> zeros = zeros_of_binary_form(c);
    if (!common) {
      common = zeros;
      continue;
    }
    std::erase_if(*common, [&](const Eigen::VectorXd& e) {
      return std::ranges::none_of(zeros, [&](const Eigen::VectorXd& other) {
        return std::abs(e[0] * other[1] - e[1] * other[0]) < coefficient_tolerance;
      });
    });
  }
  std::vector<Direction> out;
  for (const Eigen::VectorXd& e : *common) out.push_back({e, 1});
  return out;
}

/// Residuals r and their derivatives J by the unknowns.
struct Linearized {
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
};

/// Minimises the norm of a function r(x) by the method of Levenberg and Marquardt, and returns the least
/// norm. x is the first and receives the last iterate; `accept` projects each iterate onto the set of allowed
/// x.
template <class Evaluate, class Accept>
double minimize(Eigen::VectorXd& x, int steps, const Evaluate& evaluate, const Accept& accept) {
  double lambda = 1e-3;
  Linearized at = evaluate(x);
  for (int k = 0; k < steps; ++k) {
    Eigen::MatrixXd normal = at.J.transpose() * at.J;
    normal.diagonal().array() += lambda;
    const Eigen::VectorXd trial = accept(x - CholeskyFactor(normal).solve(at.J.transpose() * at.r));
    Linearized next = evaluate(trial);
    if (next.r.norm() < at.r.norm()) {
      x = trial;
      at = std::move(next);
      lambda = std::max(lambda / 10, 1e-15);
    } else {
      lambda *= 4;
    }
    if (at.r.norm() < 1e-16 || lambda > 1e12) break;
  }
  return at.r.norm();
}

/// Finds a common zero of homogeneous polynomials F on the unit sphere from `start`; empty if it fails.
std::optional<Eigen::VectorXd> search(const PolynomialRing& ring, const Eigen::MatrixXd& F,
                                      const Eigen::VectorXd& start) {
  Eigen::VectorXd e = start.normalized();
  const double left = minimize(
      e, 200,
      [&](const Eigen::VectorXd& x) {
        Linearized at{Eigen::VectorXd::Zero(F.rows() + 1), Eigen::MatrixXd(F.rows() + 1, x.size())};
        at.r.head(F.rows()) = ring.at(F, x);
        at.J << ring.gradient(F, x), x.transpose();
        return at;
      },
      [](const Eigen::VectorXd& x) { return Eigen::VectorXd(x.normalized()); });
  if (!(left < 1e-12)) return std::nullopt;
  return e;
}

/// The dimension of the cone of common zeros of homogeneous polynomials F near the zero e with |e| = 1. It
/// is 1 plus the number of linearly independent displacements from e to other zeros on the unit sphere.
/// These zeros are searched from starts at e ± 0.05 k, for each vector k of an orthonormal basis of the
/// directions orthogonal to e in which the derivative of F at e is 0.
int dimension_of_cone(const PolynomialRing& ring, const Eigen::MatrixXd& F, const Eigen::VectorXd& e) {
  constexpr double step = 0.05, shortest = 0.02, longest = 0.12;
  Eigen::MatrixXd G(F.rows() + 1, e.size());
  G << ring.gradient(F, e), e.transpose();
  const SingularValues svd = singular_values(G);
  const Eigen::MatrixXd kernel = svd.V.rightCols(e.size() - svd.rank(1e-5));
  std::vector<Eigen::VectorXd> ways;
  for (Eigen::Index k = 0; k < kernel.cols(); ++k)
    for (const double h : {step, -step}) {
      const std::optional<Eigen::VectorXd> x = search(ring, F, e + h * kernel.col(k));
      if (!x) continue;
      const Eigen::VectorXd way = (x->dot(e) < 0 ? -*x : *x) - e;
      if (!(way.norm() > shortest && way.norm() < longest)) continue;
      ways.push_back(way.normalized());
      break;
    }
  Eigen::MatrixXd all(static_cast<Eigen::Index>(ways.size()), e.size());
  for (std::size_t k = 0; k < ways.size(); ++k) all.row(static_cast<Eigen::Index>(k)) = ways[k];
  return 1 + singular_values(all).rank(0.3);
}

/// Improves an isolated common zero e, with |e| = 1, of homogeneous polynomials F in d variables. A simple
/// zero, at which ∂F/∂e has the rank d - 1, is returned unchanged. For a multiple zero, Newton's method is
/// applied to the system F(e) = 0, (∂F/∂e) λ = 0, |e| = 1, a·λ = 1 for the unknowns e and λ. The unit vector
/// a is constant; it is orthogonal to the given e, and nearly in the kernel of ∂F/∂e at the given e. Each
/// step is the least-squares solution of least norm of the linearised system, because λ is determined only up
/// to a multiple of e.
Eigen::VectorXd polished(const PolynomialRing& ring, const Eigen::MatrixXd& F, const Eigen::VectorXd& e) {
  constexpr double farthest = 1e-5, negligible = 1e-6;
  const Eigen::Index d = e.size(), m = F.rows();
  Eigen::MatrixXd G(m + 1, d);
  G << ring.gradient(F, e), e.transpose();
  const SingularValues svd = singular_values(G);
  if (svd.rank(farthest) == d) return e;
  const Eigen::VectorXd along = svd.V.rightCols(1);
  Eigen::MatrixXd whole = ring.zero(m);
  whole.leftCols(F.cols()) = F;
  std::vector<Eigen::MatrixXd> slopes;
  for (int k = 0; k < ring.variables(); ++k) slopes.push_back(ring.derivative(whole, k));
  Eigen::VectorXd x = e, lambda = along;
  for (int step = 0; step < 8; ++step) {
    Eigen::MatrixXd second = Eigen::MatrixXd::Zero(m, d);  // second derivatives of F along λ
    for (Eigen::Index k = 0; k < d; ++k)
      second += lambda[k] * ring.gradient(slopes[static_cast<std::size_t>(k)], x);
    const Eigen::MatrixXd gradient = ring.gradient(F, x);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2 * m + 2, 2 * d);
    Eigen::VectorXd r(2 * m + 2);
    J.topLeftCorner(m, d) = gradient;
    J.block(m, 0, m, d) = second;
    J.block(m, d, m, d) = gradient;
    J.block(2 * m, 0, 1, d) = x.transpose();
    J.block(2 * m + 1, d, 1, d) = along.transpose();
    r << ring.at(F, x), gradient * lambda, 0, along.dot(lambda) - 1;
    const Eigen::VectorXd change = least_squares(J, r, negligible);
    x = (x - change.head(d)).normalized();
    lambda -= change.tail(d);
  }
  return (x - e).norm() < farthest ? x : e;
}

std::vector<Direction> searched_zeros(const PolynomialRings& rings, const PolynomialRing& ring,
                                      const std::vector<Form>& rows) {
  const int starts = 80 * (ring.variables() - 1);
  constexpr int of_a_cone = 14;
  const Eigen::MatrixXd F = leading_forms(ring, rows);
  std::mt19937_64 random(0);
  std::normal_distribution<double> normal;
  std::vector<Direction> out;
  std::vector<int> found(static_cast<std::size_t>(ring.variables()) + 1, 0);
  for (int k = 0; k < starts; ++k) {
    rings.ask();
    Eigen::VectorXd start(ring.variables());
    for (double& entry : start) entry = normal(random);
    const std::optional<Eigen::VectorXd> zero = search(ring, F, start);
    if (!zero) continue;
    const Eigen::VectorXd e = on_half_sphere(*zero);
    const auto same = std::ranges::find_if(out, [&](const Direction& other) {
      return other.dimension == 1 && std::min((other.e - e).norm(), (other.e + e).norm()) < same_direction;
    });
    if (same != out.end()) continue;
    const int D = dimension_of_cone(ring, F, e);
    if (D > 1 && found[static_cast<std::size_t>(D)]++ >= of_a_cone) continue;
    out.push_back({D == 1 ? polished(ring, F, e) : e, D});
  }
  return out;
}

}  // namespace

std::vector<Direction> common_zeros(const PolynomialRings& rings, const PolynomialRing& ring,
                                    const std::vector<Form>& rows) {
  return ring.variables() == 2 ? binary_zeros(ring, rows) : searched_zeros(rings, ring, rows);
}

bool arc_exists(PolynomialRings& rings, const PolynomialRing& ring, const std::vector<Form>& rows,
                const Eigen::VectorXd& e, int order) {
  const PolynomialRing& line = rings.at(1, order);
  const int d = ring.variables(), unknowns = std::max(0, order - 2) * d;
  const auto n_rows = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd g(n_rows, ring.size());
  for (std::size_t c = 0; c < rows.size(); ++c) g.row(static_cast<Eigen::Index>(c)) = rows[c].p;
  g.rightCols(ring.size() - ring.begin(order + 1)).setZero();
  std::vector<Eigen::MatrixXd> by_variable;
  for (int k = 0; k < d; ++k) by_variable.push_back(ring.derivative(g, k));

  const auto evaluate = [&](const Eigen::VectorXd& x) {
    Eigen::MatrixXd u = line.zero(d);
    u.col(1) = e;
    u.middleCols(2, std::max(0, order - 2)) = x.reshaped(d, std::max(0, order - 2));
    Linearized at;
    at.r = ring.substitute(g, line, u).rightCols(order - 1).reshaped();
    at.J.setZero(at.r.size(), unknowns);
    if (unknowns == 0) return at;
    for (int k = 0; k < d; ++k) {
      const Eigen::MatrixXd slope = ring.substitute(by_variable[static_cast<std::size_t>(k)], line, u);
      for (int a = 2; a < order; ++a)     // the unknown of t^a
        for (int b = a; b <= order; ++b)  // the residual of t^b
          at.J.block((b - 2) * n_rows, (a - 2) * d + k, n_rows, 1) = slope.col(b - a);
    }
    return at;
  };
  const double enough = rank_tolerance / 10 * std::max(1.0, g.cwiseAbs().maxCoeff());
  if (unknowns == 0) return evaluate(Eigen::VectorXd(0)).r.norm() < 10 * enough;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns);
  for (int attempt = 0; attempt < 3; ++attempt) {
    if (minimize(x, 400, evaluate, [](const Eigen::VectorXd& trial) { return trial; }) < enough) return true;
    for (double& entry : x) entry = normal(random);
  }
  return false;
}

}  // namespace axode::higher_order
