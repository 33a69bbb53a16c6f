#pragma once
#include <functional>

#include "axode/contact/law/dense_factor.hpp"
#include "axode/contact/law/sparse_factor.hpp"
#include "axode/contact/law/velocity_problem.hpp"

namespace axode {

/// The result of a VelocitySolver: how exactly the law holds, and what it took.
struct [[nodiscard]] VelocitySolution {
  double certificate = 0;  ///< see certificate()
  int factorizations = 0;  ///< matrices that were factorised
  int restarts = 0;        ///< further starts that were needed
  bool holds(double tolerance) const { return certificate <= tolerance; }
};

/// Solves a VelocityProblem: proximal steps on the resolvent, each by Newton's method (D11.8), and Newton's
/// method on the law itself near the solution (D11.9). The unknowns are velocities or, if there are fewer
/// rows than velocities, multipliers. If Newton's method fails, it starts again from 0, and then from the
/// results of alternating directions. The best multipliers are returned with their certificate; they are
/// never those of another law.
///
/// Matrices in velocities are factorised along the bodies that touch, see SparseFactor, by Cholesky's method
/// while no contact slides; matrices in multipliers are dense, O(rows³).
class VelocitySolver {
 public:
  /// Allocates for problems with nv velocities and up to a number of rows.
  void reserve(int nv, int rows);

  /// Whether to go on with a problem that needs further starts, which may take seconds. It may be empty.
  using Monitor = std::function<bool()>;

  /// Improves λ, in the scaled rows of the problem, from its given value until the certificate is at most
  /// `tolerance`, or until the monitor returns false. It is called before each further start and each step on
  /// the path of solutions. Requires reserve(). Allocates nothing, and throws only what the monitor throws.
  VelocitySolution solve(const VelocityProblem& problem, double* lambda, double tolerance = 1e-12,
                         const Monitor& monitor = {});

 private:
  using Vector = Eigen::Map<Eigen::VectorXd>;

  void begin(const VelocityProblem& problem) noexcept;
  void analyse() noexcept;
  double certify(const double* lambda) noexcept;
  /// Resolves z_ of all blocks into `lambda`.
  void resolve_all(double* lambda) const noexcept;
  /// u_ = Yᵀ (w + Y λ) + r, and t_ = Y λ.
  void compute_velocities(const double* lambda) noexcept;

  /// Newton's method from one start.
  struct NewtonOptions {
    int failures = 8;  ///< proximal steps that may fail
    double mu = 1e-2;  ///< R = mu d² in the first proximal step
    int patience = 0;  ///< see polish()
  };
  /// Newton's method with proximal steps. Improves λ and returns its certificate.
  double newton(double* lambda, double tolerance, const NewtonOptions& options) noexcept;
  /// Whether neither a solution is found nor the monitor ends the search.
  bool searches();
  /// Runs newton() from start_ and keeps the better multipliers.
  void improve(double tolerance, const NewtonOptions& options) noexcept;
  /// A proximal step from lambda_0_: returns the norm of what is left, writes λ to resolved_ and the number
  /// of iterations to `iterations`.
  double proximal_step(double goal, int& iterations) noexcept;
  double multiplier_residual(const Vector& lambda) noexcept;
  double velocity_residual(const Vector& x, Vector& f) noexcept;
  template <class Residual>
  bool search(const Vector& from, const Vector& direction, Vector& to, double& norm,
              const Residual& residual) noexcept;
  /// Newton's method on the law itself. It ends after more than `patience` steps that do not halve the least
  /// certificate. Improves λ and returns its certificate.
  double polish(double* lambda, double tolerance, int patience) noexcept;

  /// Makes the matrices B of the blocks at z_: Z/R, or (1 - (1 - kept) Z)⁻¹ Z/R if kept > 0. Returns whether
  /// all of them are symmetric.
  bool make_matrices(double kept) noexcept;
  /// Factorises 1 + Y B Yᵀ.
  void factorize_with(bool symmetric) noexcept;
  void factorize_velocities(double kept) noexcept;
  /// Factorises 1 - Z + kept Z + Z R⁻¹ Yᵀ Y, or 1 + Z R⁻¹ Yᵀ Y if kept = 0.
  void factorize_multipliers(double kept) noexcept;
  /// a := B a, block by block.
  void multiply_blocks(Vector& a) const noexcept;

  /// Alternating directions from λ = 0, on the cones with the drift of De Saxcé, or on the laws themselves.
  void alternate(double* lambda, bool on_laws) noexcept;
  void apply_delassus(const Vector& a, Vector& out) noexcept;
  double largest_eigenvalue() noexcept;
  void factorize_shifted(double s) noexcept;
  void solve_shifted(double s, Vector& a) noexcept;

  /// A point (x, σ) of the path of solutions, or a direction with x in parts of |w|.
  struct PathVector {
    Vector x{nullptr, 0};
    double sigma = 0;
  };
  double path_residual(double sigma) noexcept;
  void linearize_path() noexcept;
  bool step_on_path(const PathVector& direction, double length, bool beyond_kink) noexcept;
  /// Follows the path of solutions for R = exp(σ) d² as σ falls, and tries newton() from its points. The path
  /// begins at the multipliers in y_.
  void follow_path(double tolerance);

  /// A certificate that needs no further start.
  static constexpr double accepted = 1e-9;

  const VelocityProblem* problem_ = nullptr;
  const Monitor* monitor_ = nullptr;
  bool stopped_ = false;  ///< whether the monitor has returned false
  VelocitySolution solution_;
  double* result_ = nullptr;  ///< the best multipliers
  int rows_ = 0;
  bool by_multipliers_ = false;
  double size_ = 0;                   ///< |w|
  int path_iterations_ = 0;           ///< of the last step on the path
  DenseFactor dense_;                 ///< of matrices in multipliers
  SparseFactor sparse_;               ///< of matrices in velocities
  std::vector<double> memory_;        ///< of the vectors below
  std::vector<double> G_memory_;      ///< Yᵀ Y if multipliers are the unknowns
  std::vector<double> matrices_;      ///< the matrix B of each block
  std::vector<double> YB_, columns_;  ///< Y B and Y of blocks that move the same velocities
  // Vectors with an entry for each row, and for each velocity.
  Vector u_{nullptr, 0}, b_{nullptr, 0}, z_{nullptr, 0}, R_{nullptr, 0}, resolved_{nullptr, 0},
      lambda_0_{nullptr, 0}, lambda_{nullptr, 0}, trial_{nullptr, 0}, step_{nullptr, 0}, best_{nullptr, 0},
      start_{nullptr, 0}, y_{nullptr, 0}, y_before_{nullptr, 0}, dual_{nullptr, 0}, residual_{nullptr, 0};
  Vector x_{nullptr, 0}, f_{nullptr, 0}, t_{nullptr, 0}, x_trial_{nullptr, 0}, f_trial_{nullptr, 0},
      dx_{nullptr, 0};
  PathVector path_point_, tangent_, next_, after_kink_;
};

}  // namespace axode
