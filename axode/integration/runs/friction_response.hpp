#pragma once
#include <span>
#include <vector>

#include "axode/integration/dry_friction.hpp"
#include "axode/integration/prescribed/closed_motion.hpp"
#include "axode/model/workspace.hpp"

namespace axode {

/// The response Φ = ∂a/∂τ of a mechanism to joint forces, for the friction that depends on accelerations.
class FrictionResponse {
 public:
  using Span = std::span<const double>;

  /// Computes the friction of joints that stick and of gears with losses at (q, v), and adds its effect to
  /// the accelerations a (nv numbers), which were computed without it. `loops` is null if the mechanism has
  /// no loops. Fails if a gear locks itself so strongly that there are no or several accelerations (D9.12);
  /// the result then contains the body that the joint of this gear moves.
  [[nodiscard]] Solvability apply(const Model& model, Workspace<>& workspace, ClosedMotion* loops,
                                  DryFriction& friction, const EnergyNorm& norm, Span q, Span v,
                                  Span through_gears, std::span<double> a);

 private:
  DryFriction::Matrix all_;      ///< Φ, without loops
  DryFriction::Matrix columns_;  ///< the columns of Φ that belong to DryFriction::resisting()
  std::vector<double> own_;      ///< argument `own` of DryFriction::apply_friction()
};

}  // namespace axode
