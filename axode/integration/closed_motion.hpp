#pragma once
#include <span>
#include <vector>

#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/loop_system.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// What a scheme asks of the loops of a mechanism: accelerations that keep them closed, and that they are closed again at
/// the end of a step, by the displacement and the impulses that move the masses least.
class ClosedMotion {
 public:
  using Span = std::span<const double>;

  explicit ClosedMotion(const Model& model);

  /// Throws std::invalid_argument where a motion cannot start at (q, v): which loop is open, or torn by how much.
  void check(Span q, Span v);
  Solvability accelerate(Span q, Span v, Span tau, const Loads<double>& loads, std::span<double> a);
  /// LoopSystem::weakest_row() of the last accelerations.
  double weakest_row();
  /// For respond(), at a place that has accelerations.
  void factorize(Span q);
  /// What a force of 1 on velocity c adds to accelerations, nv; returns what it would add to that of c without loops.
  double unit_force_response(int c, std::span<double> a);
  /// The derivatives of these accelerations by q, v and tau, [component, direction].
  void differentiate(Span q, Span v, Span tau, const Loads<double>& loads,
                     const ClosedDynamicsDerivatives<double>& d);
  /// Adds what the loops do to the joints, Aᵀ λ, under which accelerations keep them closed.
  Solvability add_constraint_forces(Span q, Span v, Span tau, const Loads<double>& loads,
                                    std::span<double> f);
  /// Whether the loops could be closed. What is 1e-13 rad and m off stays.
  [[nodiscard]] bool close(std::span<double> q, std::span<double> v);
  /// The same of places alone, and, where these are closed, of momenta p = M v.
  [[nodiscard]] bool close_places(std::span<double> q);
  [[nodiscard]] bool close_momenta(Span q, std::span<double> p);
  /// Decides on the rank of the rows, where the loops are closed already.
  void determine_rank(Span q);

 private:
  Model model_;
  LoopWorkspace<double> workspace_;
  RowRank rank_;  ///< as of the last closed configuration
  ConfigurationGroup<double> group_;
  std::vector<double> lambda_, r_, x_, a_;
};

}  // namespace axode
