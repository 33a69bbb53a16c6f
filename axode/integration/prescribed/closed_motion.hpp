#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/constraints/prescribed/motion_rows.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The loops and prescribed motions of a mechanism in a simulation. A prescribed motion counts as a loop
/// whose residual is the deviation from the motion. A ClosedMotion computes accelerations that keep the loops
/// closed. At the end of a step it changes q by a displacement and v by impulses such that the equations of
/// the loops hold; both changes are the least ones in the norm of the mass matrix ((D7.12), (D7.13) and
/// (D12.1) of docs/derivations).
class ClosedMotion {
 public:
  using Span = std::span<const double>;

  explicit ClosedMotion(const Model& model, std::span<const PrescribedMotion> more = {});

  const MotionRows& motions() const { return motions_; }
  /// The right sides of the prescribed motions at time t (s), as rows of MotionRows::model().
  std::span<const PrescribedRow<double>> motion_rows(double t) { return motions_.at(t); }
  /// Sets the time (s) at which prescribed motions are followed; it is 0 at first.
  void set_time(double t);
  /// Why the accelerations a do not follow the prescribed motions, as a sentence; empty if they do.
  std::string unfollowed(Span q, Span v, Span a);
  /// A sentence about a singularity of loops and prescribed motions near q at time t (s); empty if there is
  /// none.
  std::string singularity(Span q, double t);
  /// Throws std::invalid_argument unless the initial state (q, v) of a simulation closes the loops and
  /// follows the prescribed motions. Determines the rank of the Jacobian of the loops.
  void check(Span q, Span v);
  Solvability accelerate(Span q, Span v, Span tau, const Loads<double>& loads, std::span<double> a);
  /// How far the rows of the loops' Jacobian are from linear dependence, from 1 (far) to 0 (dependent).
  double weakest_row();
  /// Factorises the system at a q with a regular mass matrix, for unit_force_response().
  void factorize(Span q);
  /// Computes the accelerations a (nv numbers) that a unit joint force on velocity c causes, a column of
  /// ∂a/∂τ (D7.14). Returns the acceleration of c that it would cause without loops.
  double unit_force_response(int c, std::span<double> a);
  /// Computes the derivatives of the accelerations by q, v and tau, nv × nv matrices [component, direction].
  void differentiate(Span q, Span v, Span tau, const Loads<double>& loads,
                     const ClosedDynamicsDerivatives<double>& d);
  /// Adds the constraint forces Aᵀ λ of the loops to the joint forces f (nv numbers). A is the Jacobian of
  /// the loops, and the multipliers λ keep the loops closed.
  Solvability add_constraint_forces(Span q, Span v, Span tau, const Loads<double>& loads,
                                    std::span<double> f);
  /// Projects q onto closed loops, to a residual of 1e-13 (rad and m) if that can be reached, and v onto
  /// velocities that keep the loops closed. Returns false if the residual stays above 1e-6 or the mass matrix
  /// is singular.
  [[nodiscard]] bool close(std::span<double> q, std::span<double> v);
  /// close_places() projects q alone onto configurations in which the loops are closed and the prescribed
  /// motions are followed. close_momenta() projects the momenta p = M v at such a configuration onto those
  /// with which the loops stay closed and the prescribed motions are followed. Both return false if this
  /// fails.
  [[nodiscard]] bool close_places(std::span<double> q);
  /// Whether the loops are closed and the prescribed motions are followed at q, up to a residual of 1e-6
  /// (rad, m).
  [[nodiscard]] bool is_closed(Span q);
  [[nodiscard]] bool close_momenta(Span q, std::span<double> p);
  /// The multiplier of a named coupling of joints: a force after accelerate(), an impulse after bounce().
  double multiplier(std::string_view coupling) const;
  /// Changes v by impulses to v⁺ with A v⁺ = -e A v, with the Jacobian A of the loops, closed at q, and the
  /// restitution e. Returns false if the mass matrix is singular.
  [[nodiscard]] bool bounce(Span q, double restitution, std::span<double> v);
  /// Determines which rows of the loops' Jacobian are redundant at a closed q. Later solutions use this.
  void determine_rank(Span q);

 private:
  double open(Span q);  ///< norm of the residual of loops and prescribed motions

  MotionRows motions_;
  Model model_;  ///< MotionRows::model()
  LoopWorkspace<double> workspace_;
  RowRank rank_;  ///< the rank at the last closed configuration
  double time_ = 0;
  ConfigurationGroup<double> group_;
  std::vector<double> lambda_, r_, x_, a_;
};

}  // namespace axode
