#pragma once
#include "axode/contact/law/contact_system.hpp"
#include "axode/contact/law/problem_derivative.hpp"
#include "axode/contact/law/velocity_solver.hpp"

namespace axode {

/// The result of ContactDynamics::solve().
struct [[nodiscard]] ContactStatus {
  Solvability mass_matrix = {};
  VelocitySolution solution = {};
  /// Whether the mass matrix is regular and the certificate of the velocities is at most `tolerance`.
  bool holds(double tolerance = 1e-9) const { return mass_matrix.ok() && solution.holds(tolerance); }
};

/// Computes the velocities v⁺ after a step h from a state (q, v) of a mechanism with contacts, hard stops,
/// joints with dry friction and closed loops, all in one problem (D11.5): M (v⁺ - v) = h (τ - b) + Jᵀ λ, with
/// the mass matrix M, the drive forces τ, the bias forces b(q, v), and the Jacobian J and the impulses λ (N
/// s, N m s) of the constraint rows. J v⁺ + r and λ obey the laws of Signorini (contacts, stops) and Coulomb
/// (friction); for loops J v⁺ + r = 0. M, b and J are taken at (q, v), and q is not integrated. The contacts
/// are rigid.
///
/// For the normal row of a contact and for a stop, let u be the velocity of the row before the step (negative
/// during approach), `gap` its distance (negative in overlap), e its coefficient of restitution, and
/// `threshold` the speed of approach below which nothing bounces. The row bounces if e > 0, u < -threshold
/// and gap + h u ≤ 0; then r = e u. Otherwise r = max(gap/h, -5 threshold): the gap may close within the
/// step, and an overlap is removed slowly. For a row of a loop, r is its position residual divided by h. For
/// all other rows r is 0.
///
/// An object is the scratch memory of one thread and keeps the results of solve().
class ContactDynamics {
 public:
  struct Options {
    double h = 1e-3;          ///< step, s
    double threshold = 0.05;  ///< speed of approach below which nothing bounces, m/s
    double tolerance =
        1e-15;  ///< certificate at which the solver stops; it stops earlier if rounding prevents it
  };

  /// Reserves memory for `capacity` contacts with `contact_rows` constraint rows each. Throws
  /// std::invalid_argument if `contact_rows` is not 3, 4 or 6.
  explicit ContactDynamics(const Model& model, int contact_rows = 3, std::size_t capacity = 64);

  /// Computes the velocities v⁺ after a step of length h and the impulses λ of the constraint rows, from a
  /// state (q, v) with drive forces tau. The solver starts from the impulses in `start`, one for each row, or
  /// from 0 if `start` is empty. Throws std::invalid_argument if an argument has a wrong size or is not
  /// finite, if h is not positive, if options.threshold is negative, or if a contact has no unit normal, a
  /// negative friction, a restitution outside 0 to 1, a stiffness, or bodies that do not exist or are equal.
  /// Allocates nothing if there are not more contacts than the capacity or than in an earlier call.
  ContactStatus solve(std::span<const double> q, std::span<const double> v, std::span<const double> tau,
                      std::span<const Contact> contacts, const Options& options,
                      std::span<const double> start = {}, const Loads<>& loads = {});

  ContactSystem& system() { return system_; }
  const ContactSystem& system() const { return system_; }

  // Results of solve():
  std::span<const double> free_velocity() const { return free_velocity_; }  ///< v + h M⁻¹ (τ - b), nv
  std::span<const double> velocity() const { return velocity_; }            ///< v⁺, nv
  std::span<const double> impulses() const { return impulses_; }            ///< λ, a number for each row
  std::span<const double> contact_velocity() const { return contact_velocity_; }        ///< J v⁺, without r
  std::span<const double> r() const { return r_; }                                      ///< r by row, m/s
  std::span<const double> generalized_impulse() const { return generalized_impulse_; }  ///< Jᵀ λ, nv
  std::span<const LawBranch> branches() const { return branches_; }                     ///< per contact
  std::span<const char> bounces() const {
    return bounces_;
  }  ///< whether each contact, then each active stop bounces
  /// The sum of the impulses that all contacts exert on the ground, (moment; force) about the inertial
  /// origin.
  const Wrench<Spatial>& on_ground() const { return on_ground_; }

  /// The derivative ∂v⁺/∂τ of the velocities after the step by the drive forces, nv × nv. The step h, the
  /// Jacobian J, the mass matrix and the terms r that are added to the velocities of the constraint rows are
  /// held constant. If `details` is not null, it receives the derivatives of the multipliers and whether they
  /// are unique.
  Eigen::MatrixXd derivative_by_tau(ProblemDerivative* details = nullptr);
  /// The derivative ∂v⁺/∂p of the velocities after the step, nv × nv, by p = M v + h (τ - b), the momenta at
  /// the end of a step of length h without impulses, with the mass matrix M, the drive forces τ and the bias
  /// forces b. If `details` is not null, it receives the derivatives of the multipliers.
  Eigen::MatrixXd derivative_by_momenta(ProblemDerivative* details = nullptr);
  /// ∂v⁺/∂r by the number r of each row, nv × rows. `details` may be null.
  Eigen::MatrixXd derivative_by_r(ProblemDerivative* details = nullptr);
  /// The derivative ∂v⁺/∂c of the velocities after the step by the coefficient of friction c of each row, nv
  /// × rows. The column of a row is 0 if the row is no friction row or if its coefficient is 0. If `details`
  /// is not null, it receives the derivatives of the multipliers.
  Eigen::MatrixXd derivative_by_friction(ProblemDerivative* details = nullptr);

 private:
  void check(std::span<const double> q, std::span<const double> v, std::span<const double> tau,
             std::span<const Contact> contacts, const Options& options, std::span<const double> start,
             const Loads<>& loads) const;
  void classify(std::size_t contacts) noexcept;
  void set_r(std::span<const Contact> contacts, const Options& options) noexcept;
  Eigen::MatrixXd derivative(const Eigen::MatrixXd& dx, const Eigen::MatrixXd& du,
                             ProblemDerivative* details);

  ContactSystem system_;
  VelocitySolver solver_;
  double h_ = 0;
  std::vector<double> free_velocity_, velocity_, impulses_, contact_velocity_, r_, generalized_impulse_,
      multipliers_, before_, x_;
  std::vector<LawBranch> branches_;
  std::vector<char> bounces_;
  Wrench<Spatial> on_ground_{};
};

}  // namespace axode
