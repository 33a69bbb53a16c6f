#include "axode/constraints/local_mobility/branches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "axode/recursion/decompositions.hpp"

namespace axode::higher_order {
namespace {

constexpr double closed = 1e-12;     // residuals of points that count as closed
constexpr double off_branch = 0.05;  // distance from a branch, relative to the square of that from q
constexpr double at_rest = 1e-7, moved = 1e-5;
constexpr double ordinary = 10;  // coefficients far from singularities are smaller

/// The coefficients of the power series t(ζ) that inverts ζ(t) = Σ c_k t^k with c_0 = 0.
Eigen::RowVectorXd reversed(const PolynomialRing& line, const Eigen::RowVectorXd& c) {
  Eigen::RowVectorXd t = Eigen::RowVectorXd::Zero(c.size());
  t[1] = 1 / c[1];
  for (Eigen::Index k = 2; k < c.size(); ++k) t[k] -= line.substitute(c, line, t)(0, k) / c[1];
  return t;
}

/// The coefficients of the power series f = p^a for p = 1 + r_1 t + ..., by the recursion from f' p = a p' f.
Eigen::RowVectorXd power_of(const Eigen::RowVectorXd& r, double a) {
  Eigen::RowVectorXd out = Eigen::RowVectorXd::Zero(r.size());
  out[0] = 1;
  for (Eigen::Index n = 1; n < r.size(); ++n)
    for (Eigen::Index j = 1; j <= n; ++j)
      out[n] += (a * static_cast<double>(j) - static_cast<double>(n - j)) / static_cast<double>(n) * r[j] *
                out[n - j];
  return out;
}

/// Makes a branch of dimension 1, a curve of configurations, from the power series z(t) of its points in some
/// parameter t. The result is a series in another parameter: the displacement along the tangent at t = 0 or,
/// at a cusp, a root of this displacement (D13.13). If z is 0, the dimension of the branch is 0.
MotionBranch curve(const PolynomialRing& line, Eigen::MatrixXd z) {
  MotionBranch out;
  const int K = line.degree();
  int k = 1;
  while (k <= K && z.col(k).norm() < coefficient_tolerance) ++k;
  if (k > K) return out;
  z.leftCols(k).setZero();
  out.dimension = 1;
  out.power = k;
  Eigen::VectorXd t = z.col(k).normalized();
  const auto first = std::ranges::find_if(t, [](double x) { return std::abs(x) > coefficient_tolerance; });
  if (k % 2 == 1 && *first < 0) {
    for (int l = 1; l <= K; l += 2) z.col(l) *= -1;
    t = -t;
  }
  const Eigen::RowVectorXd along = t.transpose() * z;
  Eigen::RowVectorXd relative = Eigen::RowVectorXd::Zero(K + 1), zeta = relative;
  relative.head(K + 1 - k) = along.tail(K + 1 - k) / along[k];
  const Eigen::RowVectorXd root = power_of(relative, 1.0 / k);
  zeta.tail(K) = std::pow(along[k], 1.0 / k) * root.head(K);
  out.series = line.substitute(z, line, reversed(line, zeta));
  out.T = t.transpose();
  if (k == 1 && K >= 2) out.II = 2 * out.series.col(2).transpose();
  return out;
}

/// The distance from q, at most 1, up to which a power series z(w) is used. z(w) are points of a branch, a
/// smooth set of configurations with closed loops, in parameters w. The distance is estimated from the
/// largest coefficient of each degree.
double reach_of_germ(const PolynomialRing& ring, const Eigen::MatrixXd& z) {
  double out = 1;
  for (int k = 2; k <= ring.degree(); ++k) {
    const double size = z.middleCols(ring.begin(k), ring.count(k)).colwise().norm().maxCoeff();
    if (size > ordinary) out = std::min(out, std::pow(ordinary / size, 1.0 / (k - 1)));
  }
  return out;
}

/// The point at a parameter of a curve of configurations, by the first `terms` powers in its power series.
Eigen::VectorXd point_at(const MotionBranch& branch, double parameter, Eigen::Index terms) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(branch.series.rows());
  for (Eigen::Index k = terms; k > 0; --k) x = parameter * (x + branch.series.col(k));
  return x;
}

/// Returns the point of a branch (a smooth set of configurations through q) with which a given point x is
/// compared, to find out whether x lies on the branch. Points are displacements from q, and τ are the
/// components of x along the tangent space of the branch at q. If the dimension of the branch is above 1, the
/// result is its point with the components τ, computed to second order. If the branch is a curve, it is a
/// power series that begins with the given power of its parameter, and the result is its point at the
/// parameter |τ|^(1/power), with the sign of τ or, if `other_side` is set, with the opposite sign. Both
/// points can have the component τ at a cusp (power > 1).
Eigen::VectorXd nearest(const MotionBranch& branch, const Eigen::VectorXd& x, bool other_side) {
  const Eigen::VectorXd tau = branch.T * x;
  if (branch.dimension == 1) {
    const double size = std::pow(std::abs(tau[0]), 1.0 / branch.power);
    return point_at(branch, (tau[0] < 0) == other_side ? size : -size, branch.series.cols() - 1);
  }
  Eigen::VectorXd out = branch.T.transpose() * tau;
  for (Eigen::Index a = 0; a < tau.size(); ++a)
    for (Eigen::Index b = 0; b < tau.size(); ++b)
      out += 0.5 * tau[a] * tau[b] * branch.II.row(a * tau.size() + b).transpose();
  return out;
}

BranchPoint closed_point(const Closure& closure, const MotionBranch& branch, const Eigen::VectorXd& parameter,
                         const Eigen::VectorXd& guess) {
  BranchPoint point{parameter, guess, {}, 0};
  Eigen::VectorXd target = parameter;
  if (branch.dimension == 1) target[0] = std::pow(parameter[0], branch.power);
  point.residual = closure.close(point.x, branch.T, target);
  point.q = closure.configuration(point.x);
  return point;
}

void trace_curve(const Closure& closure, MotionBranch& branch) {
  const Eigen::Index K = branch.series.cols() - 1;
  const bool cusp = branch.cusp();
  const double range = reach(branch);
  for (Eigen::Index k = 1; k < K; ++k) {
    const double step = range * (cusp ? 0.4 : 0.04), far = closure.residual(point_at(branch, step, k)).norm(),
                 near = closure.residual(point_at(branch, step / 2, k)).norm();
    branch.residual_orders.push_back(near > 1e-13 ? std::log2(far / near)
                                                  : std::numeric_limits<double>::infinity());
  }
  branch.closes = true;
  const std::array<double, 4> of_line{0.02, 0.04, 0.08, 0.15}, of_cusp{0.1, 0.2, 0.3, 0.4};
  for (const double sign : {1.0, -1.0})
    for (const double step : cusp ? of_cusp : of_line) {
      const double parameter = sign * range * step;
      const Eigen::VectorXd guess = point_at(branch, parameter, K);
      BranchPoint point = closed_point(closure, branch, Eigen::VectorXd::Constant(1, parameter), guess);
      const bool there = point.residual < closed && (point.x - guess).norm() < 0.5 * guess.norm();
      if (there) {
        branch.points.push_back(std::move(point));
      } else if (cusp || step < 0.1) {
        branch.closes = false;
      }
    }
}

/// Computes the limit, for h → 0, of a difference quotient on a branch (a smooth set of configurations with
/// closed loops) by Romberg's method. Points of the branch are vectors of coordinates, which are 0 at the
/// configuration q. The orthonormal rows of T span the tangent space of the branch at q or, if the branch is
/// singular there, at a point near q, and Tᵀ c is a direction in this space. difference(a, b, h) returns the
/// quotient. It is called for four values of h, each half of the previous one, with the points a and b of the
/// branch for which T a = h c and T b = -h c. The error of the quotient must be a power series in h².
template <class Difference>
Eigen::VectorXd extrapolated(const Closure& closure, const Eigen::MatrixXd& T, const Eigen::VectorXd& c,
                             double range, const Difference& difference) {
  constexpr int levels = 4;
  double h = 0.08 * range;
  std::array<Eigen::VectorXd, levels> table;
  for (std::size_t l = 0; l < levels; ++l, h /= 2) {
    std::array<Eigen::VectorXd, 2> ends{h * (T.transpose() * c), -h * (T.transpose() * c)};
    closure.close(ends[0], T, h * c);
    closure.close(ends[1], T, -h * c);
    table[l] = difference(ends[0], ends[1], h);
  }
  double factor = 4;
  for (std::size_t depth = 1; depth < levels; ++depth, factor *= 4)
    for (std::size_t l = levels - 1; l >= depth; --l)
      table[l] = table[l] + (table[l] - table[l - 1]) / (factor - 1);
  return table[levels - 1];
}

Eigen::MatrixXd orthonormal_rows(const Eigen::MatrixXd& rows) {
  const SingularValues svd = singular_values(rows);
  return svd.V.leftCols(rows.rows()).transpose();
}

/// An orthonormal basis of the space spanned by the rows of T, which must be orthonormal. It depends on the
/// space alone, not on T: each vector is the largest column of the projector onto the space that remains,
/// divided by its norm.
Eigen::MatrixXd canonical_basis(const Eigen::MatrixXd& T) {
  Eigen::MatrixXd P = T.transpose() * T, out(T.rows(), T.cols());
  for (Eigen::Index k = 0; k < T.rows(); ++k) {
    Eigen::Index largest = 0;
    for (Eigen::Index c = 1; c < P.rows(); ++c)
      if (P(c, c) > P(largest, largest) + coefficient_tolerance) largest = c;
    const Eigen::VectorXd v = P.col(largest) / std::sqrt(P(largest, largest));
    out.row(k) = v.transpose();
    P -= v * v.transpose();
  }
  return out;
}

/// The tangent space at q of a branch (a smooth set of configurations with closed loops) of dimension above
/// 1, as orthonormal rows. It is spanned by the linear terms of the power series of the branch. If these are
/// linearly dependent, because the branch is singular at q, it is computed from differences of points of the
/// branch.
Eigen::MatrixXd tangent_space(const Closure& closure, const Germ& germ) {
  const Eigen::Index D = germ.ring->variables();
  const Eigen::MatrixXd first = germ.z.middleCols(1, D);
  if (singular_values(first).rank(coefficient_tolerance) == D)
    return canonical_basis(orthonormal_rows(first.transpose()));
  const double range = reach_of_germ(*germ.ring, germ.z);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Eigen::VectorXd w(D);
  for (double& entry : w) entry = normal(random);
  const Eigen::MatrixXd beside =
      orthonormal_rows(germ.ring->gradient(germ.z, 0.02 * range * w.normalized()).transpose());
  Eigen::MatrixXd rows(D, beside.cols());
  for (Eigen::Index k = 0; k < D; ++k)
    rows.row(k) = extrapolated(closure, beside, Eigen::VectorXd::Unit(D, k), range,
                               [](const Eigen::VectorXd& a, const Eigen::VectorXd& b, double h) {
                                 return Eigen::VectorXd((a - b) / (2 * h));
                               });
  return canonical_basis(orthonormal_rows(rows.allFinite() ? rows : beside));
}

/// Computes the second fundamental form II of a smooth set of dimension D of configurations with closed loops
/// (a branch), the second derivatives of its points by tangential coordinates a and b. II_ab is in row a D +
/// b. It is computed from second derivatives along lines in the tangent space (D13.13).
Eigen::MatrixXd second_form(const Closure& closure, const Eigen::MatrixXd& T, double range) {
  const Eigen::Index D = T.rows();
  Eigen::MatrixXd II(D * D, T.cols());
  const auto along = [&](const Eigen::VectorXd& c) {
    return extrapolated(closure, T, c, range,
                        [](const Eigen::VectorXd& a, const Eigen::VectorXd& b, double h) {
                          return Eigen::VectorXd((a + b) / (h * h));
                        });
  };
  for (Eigen::Index a = 0; a < D; ++a) II.row(a * D + a) = along(Eigen::VectorXd::Unit(D, a)).transpose();
  for (Eigen::Index a = 0; a < D; ++a)
    for (Eigen::Index b = a + 1; b < D; ++b) {
      const Eigen::VectorXd c = (Eigen::VectorXd::Unit(D, a) + Eigen::VectorXd::Unit(D, b)) / std::sqrt(2.0);
      II.row(a * D + b) = along(c).transpose() - (II.row(a * D + a) + II.row(b * D + b)) / 2;
      II.row(b * D + a) = II.row(a * D + b);
    }
  return II;
}

MotionBranch surface(const Closure& closure, const Germ& germ) {
  MotionBranch out;
  out.dimension = germ.ring->variables();
  out.T = tangent_space(closure, germ);
  const double range = reach_of_germ(*germ.ring, germ.z);
  out.II = second_form(closure, out.T, range);
  out.closes = true;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr int directions = 12;
  for (int k = 0; k < directions; ++k) {
    Eigen::VectorXd c(out.dimension);
    for (double& entry : c) entry = normal(random);
    for (const double step : {0.02, 0.1}) {
      const Eigen::VectorXd tau = range * step * c.normalized(),
                            guess = nearest(out, out.T.transpose() * tau, false);
      BranchPoint point = closed_point(closure, out, tau, guess);
      if (point.residual < closed && (point.x - guess).norm() < 5 * range * step * step) {
        out.points.push_back(std::move(point));
      } else if (step < 0.1) {
        out.closes = false;
      }
    }
  }
  return out;
}

/// Examines a point near q of a branch, a smooth set of configurations with closed loops. Finds the dimension
/// of the velocities that the loops allow there, and the loops in which something moves. Also finds the
/// coordinates that move along the branch but not at q (dead points), and those that do not move at all
/// (idle).
void look_beside(const Closure& closure, MotionBranch& branch) {
  if (branch.points.empty()) return;
  const std::size_t at = branch.dimension == 1 ? std::min<std::size_t>(2, branch.points.size() - 1) : 0;
  const SingularValues svd = singular_values(closure.jacobian(branch.points[at].x));
  const double largest = svd.s.size() > 0 ? svd.s[0] : 0;
  branch.differential_mobility_beside =
      closure.size() - svd.rank(coefficient_tolerance * std::max(1.0, largest));
  const double bound = moved * reach(branch);
  std::vector<char> moves(static_cast<std::size_t>(closure.size()), 1);
  for (int c = 0; c < closure.size(); ++c) {
    if (branch.T.col(c).norm() > at_rest) continue;
    const bool moves_beside = std::ranges::any_of(
        branch.points, [&](const BranchPoint& point) { return std::abs(point.x[c]) > bound; });
    (moves_beside ? branch.dead : branch.idle).push_back(c);
    moves[static_cast<std::size_t>(c)] = moves_beside;
  }
  branch.loops = closure.loops_of_coordinates(moves);
}

bool same(const MotionBranch& a, const MotionBranch& b) {
  if (a.dimension != b.dimension || a.power != b.power) return false;
  if (a.dimension > 1) return (a.T - a.T * b.T.transpose() * b.T).norm() < 2e-2 && (a.II - b.II).norm() < 0.5;
  const Eigen::Index k = std::min({a.series.cols(), b.series.cols(), Eigen::Index{4}});
  if ((a.series.leftCols(k) - b.series.leftCols(k)).norm() < 1e-3) return true;
  Eigen::MatrixXd mirrored = b.series.leftCols(k);  // the parameter of a cusp is found up to its sign
  for (Eigen::Index l = 1; l < k; l += 2) mirrored.col(l) *= -1;
  return a.cusp() && (a.series.leftCols(k) - mirrored).norm() < 1e-3;
}

/// Whether the points near q of a branch of dimension 1 lie on a branch of larger dimension.
bool within(const MotionBranch& line, const MotionBranch& surface) {
  return line.dimension == 1 && surface.dimension > 1 && !line.points.empty() &&
         std::ranges::all_of(line.points, [&](const BranchPoint& point) {
           return point.x.norm() > off_branch || lies_on(surface, point.x);
         });
}

}  // namespace

double reach(const MotionBranch& branch) {
  if (branch.dimension == 1)
    return reach_of_germ(PolynomialRing(1, static_cast<int>(branch.series.cols()) - 1), branch.series);
  const double size = branch.II.rowwise().norm().maxCoeff();
  return size > ordinary ? ordinary / size : 1;
}

bool lies_on(const MotionBranch& branch, const Eigen::VectorXd& x) {
  const double distance =
      std::min((nearest(branch, x, false) - x).norm(), (nearest(branch, x, true) - x).norm());
  return distance < off_branch * x.squaredNorm();
}

std::vector<MotionBranch> branches(const Closure& closure, const std::vector<Germ>& germs) {
  std::vector<MotionBranch> out;
  for (const Germ& germ : germs) {
    MotionBranch branch = germ.ring->variables() == 1 ? curve(*germ.ring, germ.z) : surface(closure, germ);
    branch.settled = germ.settled;
    branch.multiple = germ.multiple;
    if (branch.dimension == 0 ||
        std::ranges::any_of(out, [&](const MotionBranch& other) { return same(branch, other); }))
      continue;
    if (branch.dimension == 1) trace_curve(closure, branch);
    look_beside(closure, branch);
    out.push_back(std::move(branch));
  }
  const std::vector<MotionBranch> all = out;
  std::erase_if(out, [&](const MotionBranch& line) {
    return std::ranges::any_of(all, [&](const MotionBranch& other) { return within(line, other); });
  });
  return out;
}

}  // namespace axode::higher_order
