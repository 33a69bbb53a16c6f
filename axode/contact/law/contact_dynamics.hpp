#pragma once
#include "axode/contact/law/contact_system.hpp"
#include "axode/contact/law/problem_derivative.hpp"
#include "axode/contact/law/velocity_solver.hpp"

namespace axode {

/// The result of ContactDynamics::solve().
struct [[nodiscard]] ContactStatus {
  Solvability mass_matrix = {};
  VelocitySolution solution = {};
  /// Whether the velocities obey the laws to a tolerance of the certificate.
  bool holds(double tolerance = 1e-9) const { return mass_matrix.ok() && solution.holds(tolerance); }
};

/// Velocities after a step h at a state of a mechanism with contacts, hard stops, dry joints and closed
/// loops, all in one problem (D11.5): M (v⁺ - v) = h (τ - b) + Jᵀ λ, where the velocities J v⁺ + r obey the
/// laws of ContactLaw together with the impulses λ. Everything is taken at the given state; nothing is
/// integrated.
///
/// r of a normal row and of a stop is e u if the contact bounces, where u is its velocity before and e its
/// restitution: e > 0, u < -threshold, and gap + h u ≤ 0. Otherwise it is max(gap/h, -5 threshold): the gap
/// may close within the step, and overlap parts slowly. r of a loop is what is open, divided by h.
///
/// It is the scratch memory and the results of one thread. λ are in N s and N m s, rows are those of
/// ContactSystem.
class ContactDynamics {
 public:
  struct Options {
    double h = 1e-3;          ///< s
    double threshold = 0.05;  ///< speed of approach below which nothing bounces, m/s
    double tolerance =
        1e-15;  ///< certificate at which the solver stops; it stops earlier if rounding prevents it
  };

  /// See ContactSystem for the arguments.
  explicit ContactDynamics(const Model& model, int contact_rows = 3, std::size_t capacity = 64);

  /// Solves at a state q, v with drive forces tau. `start` (empty, or an impulse for each row) is where the
  /// solver starts. Throws std::invalid_argument if an argument has another size or is not finite, if h is
  /// not positive, or if a contact has no unit normal, a negative friction, or bodies that do not exist.
  /// Allocates nothing if the contacts are not more than before or than the capacity.
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
  std::span<const double> r() const { return r_; }                                      ///< m/s, by row
  std::span<const double> generalized_impulse() const { return generalized_impulse_; }  ///< Jᵀ λ, nv
  std::span<const LawBranch> branches() const { return branches_; }                     ///< of each contact
  std::span<const char> bounces() const { return bounces_; }  ///< of each contact and active stop
  /// The impulse of all contacts on the ground, about the inertial origin.
  const Wrench<Spatial>& on_ground() const { return on_ground_; }

  /// Derivatives of v⁺ (nv × nv) by the drive forces, with h, J, M and r held: h ∂v⁺/∂p.
  Eigen::MatrixXd derivative_by_tau(ProblemDerivative* details = nullptr);
  /// ∂v⁺/∂p for the momenta p = M v + h (τ - b) of the free motion, nv × nv.
  Eigen::MatrixXd derivative_by_momenta(ProblemDerivative* details = nullptr);
  /// ∂v⁺/∂r, nv × rows.
  Eigen::MatrixXd derivative_by_r(ProblemDerivative* details = nullptr);
  /// ∂v⁺/∂c by the coefficient of each friction row, nv × rows; columns of other rows are 0.
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
