#pragma once

namespace axode {

/// The law of a compliant contact: at a depth d of overlap the normal force is N = k dⁿ (1 + c d'), or 0 where
/// this is negative (Hunt and Crossley).
struct Compliance {
  double stiffness = 0;   ///< k, N/mⁿ; 0 for a rigid contact
  double exponent = 1.5;  ///< n
  double damping = 0;     ///< c, s/m

  explicit operator bool() const { return stiffness > 0; }
  /// k dⁿ (N) at a gap (m), which is negative in overlap.
  double force_at_rest(double gap) const noexcept;
};

/// The compliance of two surfaces that are pressed together: the depth is the sum of both depths. If both are
/// compliant they must have the same exponent. The damping takes the energy that both would take.
Compliance in_series(const Compliance& a, const Compliance& b) noexcept;

/// The mean normal force of a step.
struct MeanForce {
  double force = 0;         ///< N
  double slope = 0;         ///< minus its derivative by the gap at the end of the step, N/m
  double slope_before = 0;  ///< minus its derivative by the gap at the start of the step, N/m
};

/// Computes the mean normal force of a step of length h (s) between two gaps (m). Without damping its work is
/// the change of the elastic energy exactly (D11.24).
MeanForce mean_force(const Compliance& compliance, double gap_before, double gap_after, double h) noexcept;

}  // namespace axode
