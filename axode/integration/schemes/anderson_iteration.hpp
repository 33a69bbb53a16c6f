#pragma once
#include <Eigen/Core>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <vector>

#include "axode/integration/schemes/energy_norm.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode {

/// Views a std::vector as a vector of Eigen, without a copy.
inline Eigen::Map<Eigen::VectorXd> as_eigen(std::vector<double>& x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}
inline Eigen::Map<const Eigen::VectorXd> as_eigen(const std::vector<double>& x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}

/// The reason that is given for a step that did not converge.
inline constexpr const char* no_convergence =
    "the iteration of the step did not converge; try a shorter step";

/// Anderson acceleration of a fixed-point iteration x += dx(x), for example Newton's method with an
/// approximate matrix. The next x is the combination of the results x + dx of the last steps for which the dx
/// that is predicted linearly is least. The iteration converges even if the matrix has the wrong sign in a
/// few directions.
class AndersonIteration {
 public:
  using Vector = Eigen::VectorXd;
  enum class Status { iterating, converged, diverged };
  /// A part of x, and the part of dx that belongs to it.
  struct Part {
    Eigen::Ref<Vector> x;
    Eigen::Ref<const Vector> dx;
  };

  /// `norm` measures the first part of x, which must consist of velocities or accelerations.
  explicit AndersonIteration(const EnergyNorm& norm) : norm_(&norm) {}

  /// Takes a step of the iteration. x is given in parts, such as velocities and multipliers, each with its
  /// part of dx, the change of x by the iteration without acceleration. The next x replaces x. The iteration
  /// has converged if the first part of dx is a rounding error of numbers of the magnitude `size`. It has
  /// also converged if this part is small, has not halved in four steps, and is_rounding() says that it
  /// consists of rounding errors. x then becomes the x + dx of the step with the least dx so far.
  template <class F> Status update(double size, std::initializer_list<Part> parts, const F& is_rounding) {
    constexpr double rounding = 2e-14, noisy = 1e-10, ill_conditioned = 1e-7;
    constexpr int most = 60, patience = 4;
    read(parts);
    const double change = norm_->of_velocities(dx_.head(n_measured(parts)));
    if (!std::isfinite(change)) return Status::diverged;
    if (change < best_) {
      best_ = change;
      closest_ = x_ + dx_;
    }
    if (change < 0.5 * halved_) {
      halved_ = change;
      since_ = 0;
    }
    const bool stalled = ++since_ > patience && best_ < ill_conditioned * size && is_rounding();
    if (change <= rounding * size || stalled) {
      write(closest_, parts);
      return Status::converged;
    }
    write(change > noisy * size ? mixed(n_measured(parts)) : x_ + dx_, parts);
    x_before_.swap(x_);
    dx_before_.swap(dx_);
    return ++steps_ == most ? Status::diverged : Status::iterating;
  }
  Status update(double size, std::initializer_list<Part> parts) {
    return update(size, parts, [] { return true; });
  }

 private:
  static Eigen::Index n_measured(std::initializer_list<Part> parts) { return parts.begin()->x.size(); }
  void read(std::initializer_list<Part> parts) {
    Eigen::Index n = 0;
    for (const Part& part : parts) n += part.x.size();
    x_.resize(n);
    dx_.resize(n);
    Eigen::Index at = 0;
    for (const Part& part : parts) {
      x_.segment(at, part.x.size()) = part.x;
      dx_.segment(at, part.x.size()) = part.dx;
      at += part.x.size();
    }
  }
  static void write(const Vector& x, std::initializer_list<Part> parts) {
    Eigen::Index at = 0;
    for (const Part& part : parts) {
      Eigen::Ref<Vector>(part.x) = x.segment(at, part.x.size());
      at += part.x.size();
    }
  }
  Vector mixed(Eigen::Index n) {
    if (steps_ == 0) return x_ + dx_;
    constexpr Eigen::Index depth = 5;
    const Eigen::Index column = filled_ < depth ? filled_++ : oldest_++ % depth;
    changes_.conservativeResize(n, depth);
    moves_.conservativeResize(x_.size(), depth);
    const auto weighted = norm_->weights().asDiagonal();
    changes_.col(column) = weighted * (dx_ - dx_before_).head(n);
    moves_.col(column) = x_ + dx_ - x_before_ - dx_before_;
    return x_ + dx_ -
           moves_.leftCols(filled_) * least_squares(changes_.leftCols(filled_), weighted * dx_.head(n), 1e-8);
  }

  const EnergyNorm* norm_;
  Vector x_, dx_, x_before_, dx_before_, closest_;
  Eigen::MatrixXd changes_, moves_;
  Eigen::Index filled_ = 0, oldest_ = 0;
  int steps_ = 0, since_ = 0;
  double best_ = std::numeric_limits<double>::infinity(), halved_ = best_;
};

}  // namespace axode
