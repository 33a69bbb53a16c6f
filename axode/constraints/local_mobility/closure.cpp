#include "axode/constraints/local_mobility/closure.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "axode/constraints/local_mobility/closure_series.hpp"
#include "axode/eigen.hpp"
#include "axode/model/building/fault.hpp"
#include "axode/model/configuration.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode::higher_order {
namespace {

/// The share of a loop in the norm of a linear combination of equations below which it is a rounding error.
constexpr double negligible_share = 1e-6;

/// The least ratio between a given characteristic length and the mean distance of joints, and its inverse.
constexpr double least_ratio = 1e-6;

/// The points without duplicates. Points are the same if their distance is a rounding error of places, or
/// small against their distance from the first point.
std::vector<Vec3<>> distinct(const std::vector<Vec3<>>& points) {
  constexpr double same = 1e-9, of_places = 1e-14, least = 1e-15;  // least: m, for points at the origin
  std::vector<Vec3<>> out;
  for (const Vec3<>& point : points) {
    const double near = std::max({same * norm(point - points[0]), of_places * norm(point), least});
    if (std::ranges::none_of(out, [&](const Vec3<>& other) { return norm(point - other) <= near; }))
      out.push_back(point);
  }
  return out;
}

/// The mean distance between two of the points; 1 if there are no two different points.
double mean_distance(const std::vector<Vec3<>>& points) {
  double sum = 0;
  for (const Vec3<>& a : points)
    for (const Vec3<>& b : points) sum += norm(a - b);
  const auto n = static_cast<double>(points.size());
  return sum > 0 ? sum / (n * (n - 1)) : 1;
}

Vec3<> mean(const std::vector<Vec3<>>& points) {
  Vec3<> sum;
  for (const Vec3<>& point : points) sum = sum + point;
  return points.empty() ? sum : (1 / static_cast<double>(points.size())) * sum;
}

}  // namespace

Closure::Closure(const Model& model, std::span<const double> q0, double length)
    : model_(model), q0_(q0.begin(), q0.end()) {
  Walks found = walks(model, q0);
  const std::vector<Vec3<>> centers = distinct(found.centers);
  const double usual = mean_distance(centers);
  if (length > 0 && !(length >= least_ratio * usual && least_ratio * length <= usual))
    throw std::invalid_argument("length is " + to_text(length) +
                                " m, and the mean distance between two joints is " + to_text(usual) +
                                " m; choose a length of its order, so that ranks mean something");
  length_ = length > 0 ? length : usual;
  const Vec3<> center = mean(centers);
  coordinates_ = std::move(found.coordinates);
  loops_ = std::move(found.loops);
  couplings_ = std::move(found.couplings);
  outside_ = std::move(found.outside);
  unit_.resize(size());
  for (int c = 0; c < size(); ++c) unit_[c] = coordinates_[static_cast<std::size_t>(c)].angular ? 1 : length_;
  for (std::vector<PassedJoint>& loop : loops_)
    for (PassedJoint& joint : loop)
      for (std::size_t k = 0; k < joint.S.size(); ++k) {
        const Screw<> S = unit_[joint.coordinates[k]] * Ad(-center, joint.S[k]);
        joint.S[k] = {S.w, (1 / length_) * S.v};
      }
  couplings_ = couplings_ * unit_.asDiagonal();
  for (Eigen::Index k = 0; k < couplings_.rows(); ++k) couplings_.row(k).normalize();
}

std::vector<int> Closure::loops_of_equations(const Eigen::Ref<const Eigen::VectorXd>& combination) const {
  const double bound = negligible_share * combination.norm();
  std::vector<int> out;
  const auto n = static_cast<int>(loops_.size()), all = n + static_cast<int>(couplings_.rows());
  for (int l = 0; l < all; ++l)
    if ((l < n ? combination.segment<6>(6 * l).norm() : std::abs(combination[5 * n + l])) > bound)
      out.push_back(l);
  return out;
}

std::vector<int> Closure::loops_of_coordinates(const std::vector<char>& moves) const {
  std::vector<int> out;
  const auto is_moving = [&](int c) { return moves[static_cast<std::size_t>(c)] != 0; };
  for (std::size_t l = 0; l < loops_.size(); ++l)
    if (std::ranges::any_of(loops_[l], [&](const PassedJoint& joint) {
          return std::ranges::any_of(joint.coordinates, is_moving);
        }))
      out.push_back(static_cast<int>(l));
  for (Eigen::Index k = 0; k < couplings_.rows(); ++k)
    for (int c = 0; c < size(); ++c)
      if (couplings_(k, c) != 0 && is_moving(c)) {
        out.push_back(static_cast<int>(loops_.size()) + static_cast<int>(k));
        break;
      }
  return out;
}

Eigen::MatrixXd Closure::log_series(const PolynomialRing& ring, const Eigen::Ref<const Eigen::MatrixXd>& x,
                                    int degree) const {
  Eigen::MatrixXd out = ring.zero(rows());
  for (std::size_t l = 0; l < loops_.size(); ++l)
    out.middleRows(static_cast<Eigen::Index>(6 * l), 6) =
        logarithm_series(ring, twist_series(ring, loops_[l], x, degree), degree);
  out.bottomRows(couplings_.rows()) = couplings_ * x;
  return out;
}

void Closure::evaluate(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::VectorXd& r,
                       Eigen::MatrixXd* J) const {
  r.resize(rows());
  if (J) J->setZero(rows(), size());
  for (std::size_t l = 0; l < loops_.size(); ++l) {
    const auto row = static_cast<Eigen::Index>(6 * l);
    SE3<> C;
    for (const PassedJoint& joint : loops_[l]) {
      Screw<> X{};
      for (std::size_t k = 0; k < joint.S.size(); ++k) X = X + x[joint.coordinates[k]] * joint.S[k];
      if (J)
        for (std::size_t k = 0; k < joint.S.size(); ++k) {
          const Screw<> S = joint.S.size() > 1 ? dexp(X, joint.S[k]) : joint.S[k];
          J->block<6, 1>(row, joint.coordinates[k]) += to_eigen(Ad(C, S));
        }
      C = C * exp(X);
    }
    r.segment<6>(row) = to_eigen(log(C));
  }
  r.tail(couplings_.rows()) = couplings_ * x;
  if (J) J->bottomRows(couplings_.rows()) = couplings_;
}

Eigen::VectorXd Closure::residual(const Eigen::Ref<const Eigen::VectorXd>& x) const {
  Eigen::VectorXd r;
  evaluate(x, r, nullptr);
  return r;
}

Eigen::MatrixXd Closure::jacobian(const Eigen::Ref<const Eigen::VectorXd>& x) const {
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
  evaluate(x, r, &J);
  return J;
}

double Closure::close(Eigen::VectorXd& x, const Eigen::Ref<const Eigen::MatrixXd>& held,
                      const Eigen::Ref<const Eigen::VectorXd>& target) const {
  constexpr int most = 60;
  constexpr double negligible = 1e-9;  // bound on pivots of redundant rows, relative to the largest pivot
  constexpr double rounding = 1e-16, farthest = 10;
  Eigen::MatrixXd A(rows() + held.rows(), size()), J;
  Eigen::VectorXd b(A.rows()), r;
  A.bottomRows(held.rows()) = held;
  for (int k = 0; k < most; ++k) {
    evaluate(x, r, &J);
    b << r, held * x - target;
    if (b.norm() < rounding) break;
    A.topRows(rows()) = J;
    const Eigen::VectorXd step = least_squares(A, b, negligible);
    x -= step;
    if (!(step.norm() < farthest) || step.norm() < rounding) break;
  }
  return residual(x).norm();
}

std::vector<double> Closure::configuration(const Eigen::Ref<const Eigen::VectorXd>& x) const {
  std::vector<double> dv(static_cast<std::size_t>(model_.nv()), 0);
  for (std::size_t c = 0; c < coordinates_.size(); ++c)
    if (coordinates_[c].velocity >= 0)
      dv[static_cast<std::size_t>(coordinates_[c].velocity)] =
          unit_[static_cast<Eigen::Index>(c)] * x[static_cast<Eigen::Index>(c)];
  return integrate(model_, q0_, dv);
}

}  // namespace axode::higher_order
