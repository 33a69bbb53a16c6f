#pragma once

namespace axode {

/// The law of a compliant contact (Hunt and Crossley): at a depth d of overlap that grows at the rate d' the
/// normal force is N = k dⁿ (1 + c d'), or 0 where this is negative, with the stiffness k, the exponent n and
/// the damping c.
struct Compliance {
  double stiffness = 0;   ///< k, N/mⁿ; 0 for a rigid contact
  double exponent = 1.5;  ///< n
  double damping = 0;     ///< c, s/m

  explicit operator bool() const { return stiffness > 0; }
  /// k dⁿ (N) at a gap (m), which is negative in overlap.
  double force_at_rest(double gap) const noexcept;
};

/// The compliance of two surfaces in contact that act like springs in series: both carry the same force, and
/// their depths add up. If both are compliant they must have the same exponent. The damping is chosen such
/// that it dissipates the sum of what both surfaces would dissipate.
Compliance in_series(const Compliance& a, const Compliance& b) noexcept;

/// The mean normal force of a step.
struct MeanForce {
  double force = 0;         ///< N
  double slope = 0;         ///< minus its derivative by the gap at the end of the step, N/m
  double slope_before = 0;  ///< minus its derivative by the gap at the start of the step, N/m
};

/// Computes the mean normal force of a step of length h (s) in which the gap changes from `gap_before` to
/// `gap_after` (m). Without damping the work of this force is exactly the change of the elastic energy
/// (D11.24).
MeanForce mean_force(const Compliance& compliance, double gap_before, double gap_after, double h) noexcept;

}  // namespace axode
