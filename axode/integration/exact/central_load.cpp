#include "axode/integration/exact/central_load.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/recursion/decompositions.hpp"

namespace axode {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

double reserve_of(const LoadCondition& c, const VectorXd& lambda) {
  if (c.bound > 0) return c.weight * (c.bound - std::abs(lambda[c.normal]));
  double squares = 0;
  for (std::size_t k = 0; k < c.tangent.size(); ++k)
    squares += std::pow(c.factors[static_cast<Eigen::Index>(k)] * lambda[c.tangent[k]], 2);
  return c.weight * (lambda[c.normal] - std::sqrt(squares));
}

/// The barrier -log(t² - |y|²) of a cone, or -log(t) without y, of affine functions t and y of the unknowns.
struct Barrier {
  VectorXd dt;
  MatrixXd dy;  ///< a row for each component of y
  double t_0;
  VectorXd y_0;

  void add(const VectorXd& at, VectorXd& gradient, MatrixXd& hessian) const {
    const double t = t_0 + dt.dot(at);
    if (y_0.size() == 0) {
      gradient += dt / t;
      hessian.noalias() -= dt * dt.transpose() / (t * t);
      return;
    }
    const VectorXd y = y_0 + dy * at;
    const double q = (t - y.norm()) * (t + y.norm());
    const VectorXd g = 2 * (t * dt - dy.transpose() * y) / q;
    gradient += g;
    hessian.noalias() += 2 * (dt * dt.transpose() - dy.transpose() * dy) / q - g * g.transpose();
  }
  bool inside(const VectorXd& at) const {
    const double t = t_0 + dt.dot(at);
    return t > 0 && (y_0.size() == 0 || t > (y_0 + dy * at).norm());
  }
};

/// The barriers of all conditions, whose reserve must be more than the last unknown, and that of its limit.
std::vector<Barrier> barriers_of(const std::vector<LoadCondition>& conditions, const MatrixXd& basis,
                                 double most, const VectorXd& lambda) {
  const Eigen::Index n = basis.cols() + 1;
  std::vector<Barrier> all;
  const auto add = [&](double sign, int load, double constant, double weight) -> Barrier& {
    Barrier b{VectorXd::Zero(n), MatrixXd(0, n), weight * (constant + sign * lambda[load]), {}};
    b.dt.head(n - 1) = weight * sign * basis.row(load).transpose();
    b.dt[n - 1] = -1;
    return all.emplace_back(std::move(b));
  };
  for (const LoadCondition& c : conditions) {
    if (c.bound > 0) {
      add(1, c.normal, c.bound, c.weight);
      add(-1, c.normal, c.bound, c.weight);
      continue;
    }
    Barrier& b = add(1, c.normal, 0, c.weight);
    const auto rows = static_cast<Eigen::Index>(c.tangent.size());
    b.y_0.resize(rows);
    b.dy = MatrixXd::Zero(rows, n);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const int load = c.tangent[static_cast<std::size_t>(k)];
      b.y_0[k] = c.weight * c.factors[k] * lambda[load];
      b.dy.row(k).head(n - 1) = c.weight * c.factors[k] * basis.row(load);
    }
  }
  Barrier limit{VectorXd::Zero(n), MatrixXd(0, n), most, {}};
  limit.dt[n - 1] = -1;
  all.push_back(std::move(limit));
  return all;
}

}  // namespace

double least_reserve(const std::vector<LoadCondition>& conditions, const VectorXd& lambda) {
  double least = std::numeric_limits<double>::infinity();
  for (const LoadCondition& c : conditions) least = std::min(least, reserve_of(c, lambda));
  return least;
}

double maximise_reserve(const std::vector<LoadCondition>& conditions, const MatrixXd& basis, double most,
                        VectorXd& lambda) {
  const double start = least_reserve(conditions, lambda);
  constexpr double ample = 1e-3;
  if (basis.cols() == 0 || conditions.empty() || start > ample * most) return start;
  const std::vector<Barrier> barriers = barriers_of(conditions, basis, most, lambda);
  const Eigen::Index n = basis.cols() + 1;
  VectorXd at = VectorXd::Zero(n), gradient(n);
  MatrixXd hessian(n, n);
  at[n - 1] = std::min(start, 0.0) - most;
  constexpr double quick = 0.25, precise = 1e-15, fall = 0.2;
  constexpr int most_iterations = 300, most_on_a_level = 30;
  double level = most - at[n - 1];
  for (int k = 0, here = 0; k < most_iterations; ++k) {
    gradient.setZero();
    hessian.setZero();
    for (const Barrier& b : barriers) b.add(at, gradient, hessian);
    gradient[n - 1] += 1 / level;
    const VectorXd step = LdltFactor(-hessian).solve(gradient);
    const double decrement = std::sqrt(std::max(0.0, gradient.dot(step)));
    if (!std::isfinite(decrement)) break;
    const VectorXd next = at + step / (decrement > quick ? 1 + decrement : 1);
    if (!std::ranges::all_of(barriers, [&](const Barrier& b) { return b.inside(next); })) break;
    at = next;
    if (decrement > quick && ++here < most_on_a_level) continue;
    here = 0;
    if (level < precise * most) break;
    level *= fall;
  }
  const VectorXd moved = lambda + basis * at.head(n - 1);
  const double reached = least_reserve(conditions, moved);
  if (!(reached >= start)) return start;
  lambda = moved;
  return std::min(reached, most);
}

}  // namespace axode
