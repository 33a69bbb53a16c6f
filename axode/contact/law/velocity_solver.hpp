#pragma once
#include <functional>

#include "axode/contact/law/dense_factor.hpp"
#include "axode/contact/law/sparse_factor.hpp"
#include "axode/contact/law/velocity_problem.hpp"

namespace axode {

/// The result of VelocitySolver::solve(): how exactly the laws hold, and the number of operations.
struct [[nodiscard]] VelocitySolution {
  double certificate = 0;  ///< see certificate()
  int factorizations = 0;  ///< number of matrices that were factorised
  int restarts = 0;        ///< number of further starts
  bool holds(double tolerance) const { return certificate <= tolerance; }
};

/// Solves a VelocityProblem: finds multipliers λ of constraint rows with λ = resolve(λ - u/d²), where u are
/// the velocities of the rows for λ, `resolve` maps a trial impulse to the impulse that the law of contact
/// allows, and d² is about the diagonal entry of J M⁻¹ Jᵀ for a row, with the Jacobian J of the rows and the
/// mass matrix M. The solver makes proximal steps: from multipliers λ_0, a step solves λ = resolve(λ_0 - u/R)
/// by Newton's method, with a factor R for each row (D11.8). Near the solution, Newton's method is applied to
/// the laws themselves (D11.9). If the certificate (the error of the laws relative to the velocities of the
/// mechanism) stays above 1e-9, the solver starts again: from 0, from the results of alternating directions
/// (D11.10), from solutions of easier problems with compliant contacts (D11.10a), and from disturbed
/// multipliers. The result is the multipliers with the least certificate.
///
/// The unknowns of Newton's method are velocities or multipliers, whichever takes fewer operations. Matrices
/// for velocities are sparse, because a contact couples only the velocities that move its two bodies. They
/// are factorised in an order of least degree, by Cholesky's method while no contact slides. Matrices for
/// multipliers are dense and take O(rows³).
class VelocitySolver {
 public:
  /// Allocates memory for problems with up to nv velocities and up to `rows` rows.
  void reserve(int nv, int rows);

  /// Callback that is called before the solver starts again from other multipliers, which may take seconds.
  /// If it returns false, the search ends. May be empty.
  using Monitor = std::function<bool()>;

  /// Improves the multipliers `lambda` of the constraint rows from their given values, until the certificate
  /// (the error of the laws relative to the velocities of the mechanism) is at most `tolerance` or the
  /// iteration stalls. `lambda` has a number for each scaled row: friction rows are multiplied by their
  /// coefficients of friction. If the certificate is then above 1e-9, the solver starts again from other
  /// multipliers. It calls `monitor`, unless this is empty, before each new start and repeatedly while it
  /// looks for starts, and ends if `monitor` returns false. reserve() must have been called before. Allocates
  /// nothing, and throws only what `monitor` throws.
  VelocitySolution solve(const VelocityProblem& problem, double* lambda, double tolerance = 1e-12,
                         const Monitor& monitor = {});

  /// Whether solve() may begin with the factors of the last matrix of an earlier call, if all blocks are on
  /// the same branches of their laws (such as stick). It makes new factors if the old ones do not lower the
  /// certificate to a thousandth in one step. Results then depend on earlier calls, within the tolerance.
  bool keeps_factors = false;
  void forget_factors() noexcept { branches_.clear(); }
  /// Takes the factors of another solver. Both must have reserved the same memory.
  void continue_from(const VelocitySolver& other);

 private:
  using Vector = Eigen::Map<Eigen::VectorXd>;

  void begin(const VelocityProblem& problem) noexcept;
  void keep_factors() noexcept;
  bool has_factors() const noexcept;
  void analyse() noexcept;
  double certify(const double* lambda) noexcept;
  /// Maps the trial impulses z_ of all constraint rows to the impulses that the laws of contact allow, by
  /// resolve(), and writes them to `lambda`.
  void resolve_all(double* lambda) const noexcept;
  /// Computes t_ = Y λ and the velocities u_ = Yᵀ (w + Y λ) + r of the constraint rows for the multipliers λ.
  void compute_velocities(const double* lambda) noexcept;

  /// Options of newton().
  struct NewtonOptions {
    int failures = 8;  ///< number of proximal steps that may fail
    double mu = 1e-2;  ///< number μ with R = μ d² in the first proximal step
    int patience = 0;  ///< see polish()
  };
  /// Improves the multipliers λ. It makes proximal steps (D11.8) and, while the certificate (the error of the
  /// laws relative to the velocities of the mechanism) is below 1e-2, tries Newton's method on the laws
  /// (D11.9). Returns the certificate.
  double newton(double* lambda, double tolerance, const NewtonOptions& options) noexcept;
  /// Whether to go on: the least certificate is above `accepted`, and the monitor has not ended the search.
  bool searches();
  /// Runs Newton's method from start_, and keeps the result if its error of the laws is the least so far.
  void improve(double tolerance, const NewtonOptions& options) noexcept;
  /// Makes a proximal step from the multipliers λ_0 in lambda_0_: solves λ = resolve(λ_0 - u/R) by Newton's
  /// method (D11.8), where u are the velocities of the constraint rows for λ, R is a factor for each row, and
  /// `resolve` maps a trial impulse to the impulse that the law of contact allows. Ends when the norm of the
  /// residual is at most `goal` or does not decrease, or after 10 Newton steps. Writes λ to resolved_ and the
  /// number of Newton steps to `iterations`, and returns the norm of the residual.
  double proximal_step(double goal, int& iterations) noexcept;
  double multiplier_residual(const Vector& lambda) noexcept;
  double velocity_residual(const Vector& x, Vector& f) noexcept;
  template <class Residual>
  bool search(const Vector& from, const Vector& direction, Vector& to, double& norm,
              const Residual& residual) noexcept;
  /// Improves the multipliers λ of the constraint rows by Newton's method for the laws of contact
  /// λ = resolve(λ - u/d²) (D11.9), where u are the velocities of the rows for λ, `resolve` maps a trial
  /// impulse to the impulse that the law allows, and d² is about the diagonal entry of J M⁻¹ Jᵀ for a row,
  /// with the Jacobian J of the rows and the mass matrix M. The last call of certify() must have been for the
  /// given λ, and e is its result. Ends when the certificate, the error of the laws relative to the
  /// velocities of the mechanism, is at most `tolerance`, after more than `patience` steps that do not halve
  /// its least value, or after 8 + 2 patience steps. Returns the least certificate of all λ, including the
  /// first, and writes the λ that has it to `lambda`.
  double polish(double* lambda, double tolerance, int patience, double e) noexcept;

  /// Makes the matrix B of Newton's method for each block of constraint rows (such as the rows of one
  /// contact): if the velocities u of the block change by δu, the linearised law changes its impulses λ by -B
  /// δu. Z is the derivative, at the trial impulse z_, of the map `resolve` from a trial impulse to the
  /// impulse that the law of contact allows, and R is a factor for each row. For a proximal step, λ =
  /// resolve(λ_0 - u/R) with constant λ_0, `kept` is 0 and B = Z/R. For the laws themselves, λ = resolve(λ -
  /// u/R), B is (1 - (1 - kept) Z)⁻¹ Z/R with a small number `kept` > 0, so that the inverse exists if the
  /// block sticks and Z = 1 (D11.9). Returns whether the matrices of all blocks are symmetric.
  bool make_matrices(double kept) noexcept;
  /// Factorises the matrix 1 + Y B Yᵀ of Newton's method in velocities. Y is D^-½ L⁻ᵀ Jᵀ for the Jacobian J
  /// of the constraint rows and the mass matrix Lᵀ D L. B is block diagonal, with the matrices of
  /// make_matrices() as blocks: if the velocities of the rows of a block change by δu, the linearised law
  /// changes their impulses by -B δu. `symmetric` says whether all blocks of B are symmetric.
  void factorize_with(bool symmetric) noexcept;
  void factorize_velocities(double kept) noexcept;
  /// Factorises the matrix of Newton's method whose unknowns are the multipliers λ of the constraint rows. Z
  /// is the derivative of the map `resolve` from a trial impulse to the impulse that the law of contact
  /// allows, u are the velocities of the rows, R is a factor for each row, and Yᵀ Y = J M⁻¹ Jᵀ with the
  /// Jacobian J of the rows and the mass matrix M. For a proximal step, λ = resolve(λ_0 - u/R) with constant
  /// λ_0, `kept` is 0 and the matrix is 1 + Z R⁻¹ Yᵀ Y. For the laws themselves, λ = resolve(λ - u/R), it is
  /// 1 - (1 - kept) Z + Z R⁻¹ Yᵀ Y with a small number `kept` > 0, which makes the matrix regular if contacts
  /// are redundant (D11.9).
  void factorize_multipliers(double kept) noexcept;
  /// Computes a := B a, where B is block diagonal and has the matrices of make_matrices() as blocks.
  void multiply_blocks(Vector& a) const noexcept;

  /// Runs the alternating direction method of multipliers (D11.10) from λ = 0, and writes the multipliers
  /// with the least certificate (the error of the laws relative to the velocities of the mechanism) to
  /// `lambda`. Each iteration maps the trial impulses of every block of constraint rows (such as the rows of
  /// one contact) to impulses that the law of the block allows. If `on_laws`, this map is resolve(), with
  /// which λ and the velocities u of the rows obey the exact law if and only if λ = resolve(λ - u/R), for any
  /// R > 0. Otherwise it is the projection on the friction cone, and the norm of the velocities of the
  /// friction rows, times their coefficients, is added to the normal velocity of each contact (De Saxcé's
  /// form of the law).
  void alternate(double* lambda, bool on_laws) noexcept;
  void apply_delassus(const Vector& a, Vector& out) noexcept;
  double largest_eigenvalue() noexcept;
  void factorize_shifted(double s) noexcept;
  void solve_shifted(double s, Vector& a) noexcept;

  /// A point (x, σ) of the path of solutions (D11.10a), or a direction in which x is a multiple of |w|.
  struct PathVector {
    Vector x{nullptr, 0};
    double sigma = 0;
  };
  double path_residual(double sigma) noexcept;
  void linearize_path() noexcept;
  bool step_on_path(const PathVector& direction, double length, bool beyond_kink) noexcept;
  /// Finds starts for Newton's method from easier contact problems, in which contacts have a compliance R: λ
  /// = resolve(λ_0 - u/R) with the constant multipliers λ_0 in y_ (D11.10a). u are the velocities of the
  /// constraint rows, and `resolve` maps a trial impulse to the impulse that the law allows. R is exp(σ) d²
  /// with one number σ for all rows, where d² is about the diagonal entry of J M⁻¹ Jᵀ for a row, with the
  /// Jacobian J of the rows and the mass matrix M. The solutions for all σ form a path. The function follows
  /// it from R = 100 d², where the solution is near resolve(λ_0), towards smaller σ, and runs Newton's method
  /// for contacts without compliance from points of the path.
  void follow_path(double tolerance);

  /// The largest certificate at which no further start is made.
  static constexpr double accepted = 1e-9;

  const VelocityProblem* problem_ = nullptr;
  const Monitor* monitor_ = nullptr;
  bool stopped_ = false;  ///< whether the monitor has returned false
  VelocitySolution solution_;
  double* result_ = nullptr;  ///< the best multipliers
  int rows_ = 0;
  bool by_multipliers_ = false;
  double size_ = 0;                   ///< |w|
  int path_iterations_ = 0;           ///< iterations in the last step on the path
  DenseFactor dense_;                 ///< factors of matrices in multipliers
  SparseFactor sparse_;               ///< factors of matrices in velocities
  std::vector<double> memory_;        ///< memory of the vectors below
  std::vector<double> G_memory_;      ///< Yᵀ Y if multipliers are the unknowns
  std::vector<double> matrices_;      ///< the matrix B of each block
  std::vector<LawBranch> branches_;   ///< of each block in the kept factors; empty if there are none
  int factorized_rows_ = 0;           ///< of the kept factors; negative if their unknowns are velocities
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
