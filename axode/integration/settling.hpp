#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <vector>

#include "axode/recursion/least_squares.hpp"

namespace axode {

/// How a step of an implicit scheme ended; where the system could not be evaluated it says why itself.
enum class StepOutcome { found, impossible, diverged };

/// An iteration x += dx(x), of which Newton's method with a matrix that is nearly right is one, on its way to dx = 0. By Anderson's
/// mixing: of the combinations of the last steps that which would have changed least is taken. So it comes through
/// where the matrix has the wrong sign in a few directions, as where branches of a motion meet within a step.
class Settling {
 public:
  using Numbers = std::vector<double>;
  enum class Verdict { going, settled, diverged };
  /// A part of x, and its dx.
  struct Part {
    Numbers& x;
    const Numbers& dx;
  };

  /// Takes a step, of which the first part is measured, against a size. Where rounding lets it come no closer, not to half in four
  /// steps, it settles where it came closest.
  Verdict take(double size, std::initializer_list<Part> parts) {
    constexpr double rounding = 2e-14, noisy = 1e-10, ill_conditioned = 1e-7;
    constexpr int most = 60, patience = 4;
    read(parts);
    const double change = dx_.head(measured(parts)).lpNorm<Eigen::Infinity>();
    if (!std::isfinite(change)) return Verdict::diverged;
    if (change < best_) best_ = change, closest_ = x_ + dx_;
    if (change < 0.5 * halved_) halved_ = change, since_ = 0;
    if (change <= rounding * size || (++since_ > patience && best_ < ill_conditioned * size)) {
      write(closest_, parts);
      return Verdict::settled;
    }
    write(change > noisy * size ? mixed(measured(parts)) : x_ + dx_, parts);
    x_before_ = x_, dx_before_ = dx_;
    return ++steps_ == most ? Verdict::diverged : Verdict::going;
  }

 private:
  using Vector = Eigen::VectorXd;

  static Eigen::Index measured(std::initializer_list<Part> parts) {
    return static_cast<Eigen::Index>(parts.begin()->x.size());
  }
  void read(std::initializer_list<Part> parts) {
    std::size_t n = 0;
    for (const Part& part : parts) n += part.x.size();
    x_.resize(static_cast<Eigen::Index>(n)), dx_.resize(x_.size());
    Eigen::Index at = 0;
    for (const Part& part : parts)
      for (std::size_t k = 0; k < part.x.size(); ++k, ++at) x_[at] = part.x[k], dx_[at] = part.dx[k];
  }
  static void write(const Vector& x, std::initializer_list<Part> parts) {
    Eigen::Index at = 0;
    for (const Part& part : parts)
      for (double& x_k : part.x) x_k = x[at++];
  }
  Vector mixed(Eigen::Index measured) {
    if (steps_ == 0) return x_ + dx_;
    constexpr Eigen::Index depth = 5;
    const Eigen::Index column = filled_ < depth ? filled_++ : oldest_++ % depth;
    changes_.conservativeResize(measured, depth), moves_.conservativeResize(x_.size(), depth);
    changes_.col(column) = (dx_ - dx_before_).head(measured);
    moves_.col(column) = x_ + dx_ - x_before_ - dx_before_;
    return x_ + dx_ -
           moves_.leftCols(filled_) * least_squares(changes_.leftCols(filled_), dx_.head(measured), 1e-8);
  }

  Vector x_, dx_, x_before_, dx_before_, closest_;
  Eigen::MatrixXd changes_, moves_;
  Eigen::Index filled_ = 0, oldest_ = 0;
  int steps_ = 0, since_ = 0;
  double best_ = std::numeric_limits<double>::infinity(), halved_ = best_;
};

/// The largest number, and 1.
inline double scale_of(const std::vector<double>& x) {
  double most = 1;
  for (const double x_k : x) most = std::max(most, std::abs(x_k));
  return most;
}

}  // namespace axode
