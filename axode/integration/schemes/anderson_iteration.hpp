#pragma once
#include <Eigen/Core>
#include <initializer_list>
#include <limits>
#include <vector>

#include "axode/integration/schemes/energy_norm.hpp"

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
  /// part of dx, the change of x by the fixed-point iteration without Anderson's method. The first part must
  /// consist of velocities or accelerations. The next x replaces x. `size` is the norm of the largest terms
  /// from which the first part of x is computed, a scale for its rounding errors. The iteration has converged
  /// if the norm of the first part of dx is at most 2e-14 `size`. It has also converged if this norm has been
  /// below 1e-7 `size` and has not halved in the last four steps, and if is_rounding() returns true, that is,
  /// if dx consists of rounding errors. If the iteration has converged, x becomes the x + dx of the step in
  /// which the norm was least.
  template <class F> Status update(double size, std::initializer_list<Part> parts, const F& is_rounding) {
    const bool stalled = read(size, parts);
    return advance(size, parts, stalled && is_rounding());
  }
  Status update(double size, std::initializer_list<Part> parts) {
    return update(size, parts, [] { return true; });
  }

 private:
  /// Reads x and dx from `parts`; the first part consists of velocities or accelerations, and others may be
  /// multipliers. Returns whether the norm of the first part of dx has been below 1e-7 `size` and has not
  /// halved in the last four steps. `size` is the norm of the largest terms from which the first part of x is
  /// computed.
  bool read(double size, std::initializer_list<Part> parts);
  Status advance(double size, std::initializer_list<Part> parts, bool is_rounding);
  /// The combination of the results of the last steps, for n measured numbers.
  Vector mixed(Eigen::Index n);

  const EnergyNorm* norm_;
  Vector x_, dx_, x_before_, dx_before_, closest_;
  Eigen::MatrixXd changes_, moves_;
  Eigen::Index filled_ = 0, oldest_ = 0;
  int steps_ = 0, since_ = 0;
  double change_ = 0;  ///< norm of the first part of dx
  double best_ = std::numeric_limits<double>::infinity(), halved_ = best_;
};

}  // namespace axode
