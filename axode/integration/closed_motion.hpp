#pragma once
#include <span>
#include <vector>

#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The loops of a mechanism in a simulation: accelerations that keep them closed, and projections at the end
/// of a step, by the displacement and the impulses that move the masses least. See (D7.12) and (D7.13) of
/// docs/derivations.
class ClosedMotion {
 public:
  using Span = std::span<const double>;

  explicit ClosedMotion(const Model& model);

  /// Throws std::invalid_argument, with the loop and its residual, if a motion cannot start at (q, v).
  void check(Span q, Span v);
  Solvability accelerate(Span q, Span v, Span tau, const Loads<double>& loads, std::span<double> a);
  /// LoopSystem::weakest_row() of the last accelerations.
  double weakest_row();
  /// Prepares unit_force_response() at a q with a regular mass matrix.
  void factorize(Span q);
  /// Computes the accelerations (nv) that a unit force on velocity c adds, a column of (D7.14). Returns the
  /// acceleration that it would add to c without loops.
  double unit_force_response(int c, std::span<double> a);
  /// Computes the derivatives of the accelerations by q, v and tau, [component, direction].
  void differentiate(Span q, Span v, Span tau, const Loads<double>& loads,
                     const ClosedDynamicsDerivatives<double>& d);
  /// Adds the forces Aᵀ λ of the loops on the joints with which accelerations keep them closed.
  Solvability add_constraint_forces(Span q, Span v, Span tau, const Loads<double>& loads,
                                    std::span<double> f);
  /// Projects q and v onto the loops; returns whether they could be closed. A residual of 1e-13 rad and m is
  /// left.
  [[nodiscard]] bool close(std::span<double> q, std::span<double> v);
  /// Projects q alone, and, at a closed q, the momenta p = M v.
  [[nodiscard]] bool close_places(std::span<double> q);
  [[nodiscard]] bool close_momenta(Span q, std::span<double> p);
  /// Determines the rank of the rows at a closed q.
  void determine_rank(Span q);

 private:
  Model model_;
  LoopWorkspace<double> workspace_;
  RowRank rank_;  ///< the rank at the last closed configuration
  ConfigurationGroup<double> group_;
  std::vector<double> lambda_, r_, x_, a_;
};

}  // namespace axode
