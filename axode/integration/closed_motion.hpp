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

/// The loops and prescribed motions of a mechanism in a simulation: accelerations that keep the loops closed
/// and follow the motions, and projections at the end of a step, by the displacement and the impulses that
/// move the masses least. Motions are loops here, which are open as far as they are not followed. See
/// (D7.12), (D7.13) and (D12.1) of docs/derivations.
class ClosedMotion {
 public:
  using Span = std::span<const double>;

  explicit ClosedMotion(const Model& model, std::span<const PrescribedMotion> more = {});

  const MotionRows& motions() const { return motions_; }
  /// Sets the time at which the motions are followed; it is 0 at first.
  void set_time(double t);
  /// Why the last accelerations at a motion (q, v, a) do not follow the motions; empty if they do.
  std::string unfollowed(Span q, Span v, Span a);
  /// nearby_singularity() at q.
  std::string singularity(Span q, double t);
  /// Throws std::invalid_argument, with the loop and its residual, if a motion cannot start at (q, v).
  void check(Span q, Span v);
  Solvability accelerate(Span q, Span v, Span tau, const Loads<double>& loads, std::span<double> a);
  /// How far the rows were from redundant when accelerations were last computed, see
  /// LoopSystem::weakest_row().
  double weakest_row();
  /// Prepares unit_force_response() at a q with a regular mass matrix.
  void factorize(Span q);
  /// Computes the accelerations (nv numbers) that a unit force on velocity c causes, a column of (D7.14).
  /// Returns the acceleration of c that it would cause without loops.
  double unit_force_response(int c, std::span<double> a);
  /// Computes the derivatives of the accelerations by q, v and tau, [component, direction].
  void differentiate(Span q, Span v, Span tau, const Loads<double>& loads,
                     const ClosedDynamicsDerivatives<double>& d);
  /// Adds the forces Aᵀ λ of the loops to the forces of the joints. λ are the multipliers for which the
  /// accelerations keep the loops closed.
  Solvability add_constraint_forces(Span q, Span v, Span tau, const Loads<double>& loads,
                                    std::span<double> f);
  /// Projects q and v so that the loops are closed, to a residual of 1e-13 rad and m. Returns whether they
  /// could be closed.
  [[nodiscard]] bool close(std::span<double> q, std::span<double> v);
  /// Projects q only, as close() does. The second function projects, at a closed q, the momenta p = M v.
  [[nodiscard]] bool close_places(std::span<double> q);
  [[nodiscard]] bool close_momenta(Span q, std::span<double> p);
  /// The multiplier of a coupling at the last accelerations, or its impulse after the last bounce().
  double multiplier(std::string_view coupling) const;
  /// Changes v by impulses to A v⁺ = -e A v at a closed q, or returns false if the mass matrix is singular.
  [[nodiscard]] bool bounce(Span q, double restitution, std::span<double> v);
  /// Determines the rank of the rows at a closed q.
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
