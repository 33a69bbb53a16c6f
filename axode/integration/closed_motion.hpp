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

/// The loops and prescribed motions of a mechanism in a simulation. It computes accelerations that keep the
/// loops closed and follow the motions. At the end of a step it projects q onto closed loops by a
/// displacement, and v by impulses, which are least in the norm of the mass matrix. Prescribed motions are
/// treated as loops, which are open by as much as the mechanism deviates from the motions. See (D7.12),
/// (D7.13) and (D12.1) of docs/derivations.
class ClosedMotion {
 public:
  using Span = std::span<const double>;

  explicit ClosedMotion(const Model& model, std::span<const PrescribedMotion> more = {});

  const MotionRows& motions() const { return motions_; }
  /// Sets the time (s) at which prescribed motions are followed; it is 0 at first.
  void set_time(double t);
  /// The reason, as a sentence, why the accelerations a of the last accelerate() at (q, v) do not follow the
  /// prescribed motions; empty if they do.
  std::string unfollowed(Span q, Span v, Span a);
  /// A sentence about a singularity of the loops and prescribed motions near q at time t (s), as
  /// nearby_singularity() gives it; empty if there is none.
  std::string singularity(Span q, double t);
  /// Throws std::invalid_argument, with the loop and its residual, if loops are not closed or motions are not
  /// followed at the state (q, v) at which a simulation starts. Determines the rank of the Jacobian of the
  /// loops.
  void check(Span q, Span v);
  Solvability accelerate(Span q, Span v, Span tau, const Loads<double>& loads, std::span<double> a);
  /// How far the rows of the Jacobian of the loops were from linearly dependent in the last accelerate(): 1
  /// if far, near 0 if a row nearly depended on others. See LoopSystem::weakest_row().
  double weakest_row();
  /// Factorises the system at a q with a regular mass matrix, for unit_force_response().
  void factorize(Span q);
  /// Computes the accelerations a (nv numbers) that a unit joint force on velocity c causes, a column of
  /// ∂a/∂τ (D7.14). Returns the acceleration of c that this force would cause without loops.
  double unit_force_response(int c, std::span<double> a);
  /// Computes the derivatives of the accelerations by q, v and tau, nv × nv matrices [component, direction].
  void differentiate(Span q, Span v, Span tau, const Loads<double>& loads,
                     const ClosedDynamicsDerivatives<double>& d);
  /// Adds the forces Aᵀ λ with which the loops act to the joint forces f (nv numbers). A is the Jacobian of
  /// the loops, and λ are the multipliers for which the accelerations keep the loops closed.
  Solvability add_constraint_forces(Span q, Span v, Span tau, const Loads<double>& loads,
                                    std::span<double> f);
  /// Projects q onto closed loops by a few iterations, which end at a residual of 1e-13 (rad and m) or when
  /// the residual no longer halves, and v onto velocities that keep the loops closed. Returns false if the
  /// residual stays above 1e-6 or the mass matrix is singular.
  [[nodiscard]] bool close(std::span<double> q, std::span<double> v);
  /// close_places() projects q onto closed loops as close() does, and leaves velocities alone.
  /// close_momenta() projects the momenta p = M v at a closed q so that the velocities keep the loops closed.
  /// Both return false if this is not possible.
  [[nodiscard]] bool close_places(std::span<double> q);
  [[nodiscard]] bool close_momenta(Span q, std::span<double> p);
  /// The multiplier of the coupling with the given name: its force in the last accelerate(), or its impulse
  /// in the last bounce().
  double multiplier(std::string_view coupling) const;
  /// Changes v by impulses to the v⁺ with A v⁺ = -e A v at a closed q, where A is the Jacobian of the loops
  /// and e the coefficient of restitution. Returns false if the mass matrix is singular.
  [[nodiscard]] bool bounce(Span q, double restitution, std::span<double> v);
  /// Determines which rows of the loops' Jacobian are redundant at a closed q. Later solutions use this.
  void determine_rank(Span q);

 private:
  MotionRows motions_;
  Model model_;  ///< MotionRows::model()
  LoopWorkspace<double> workspace_;
  RowRank rank_;  ///< the rank at the last closed configuration
  double time_ = 0;
  ConfigurationGroup<double> group_;
  std::vector<double> lambda_, r_, x_, a_;
};

}  // namespace axode
