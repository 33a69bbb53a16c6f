#include "axode/contact/compliance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace axode {
namespace {

/// The elastic part k dⁿ of the mean force, and its derivatives by the depths at both ends.
MeanForce mean_elastic_force(const Compliance& it, double gap_before, double gap_after) noexcept {
  const double k = it.stiffness, n = it.exponent;
  const double before = std::max(-gap_before, 0.0), after = std::max(-gap_after, 0.0);
  const double closing = gap_before - gap_after;
  constexpr double nearly_equal = 0.05;
  if (before > 0 && after > 0 && std::abs(closing) <= nearly_equal * before) {
    // The difference of energies would lose digits. Gauss' rule with four points is exact to rounding here.
    constexpr std::array<double, 4> points{0.069431844202973712, 0.33000947820757187, 0.66999052179242813,
                                           0.93056815579702629};
    constexpr std::array<double, 4> weights{0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                            0.17392742256872693};
    MeanForce mean;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double d = before + points[i] * closing, force = k * std::pow(d, n);
      mean.force += weights[i] * force;
      const double slope = weights[i] * n * force / d;
      mean.slope += points[i] * slope;
      mean.slope_before += (1 - points[i]) * slope;
    }
    return mean;
  }
  if (before == 0 && after == 0) return {};
  const double force = k * std::pow(after, n), force_before = k * std::pow(before, n);
  const double energy = force * after - force_before * before;
  const double mean = energy / (n + 1) / closing;
  return {mean, (force - mean) / closing, (mean - force_before) / closing};
}

}  // namespace

double Compliance::force_at_rest(double gap) const noexcept {
  return gap < 0 ? stiffness * std::pow(-gap, exponent) : 0;
}

Compliance in_series(const Compliance& a, const Compliance& b) noexcept {
  if (!a) return b;
  if (!b) return a;
  const double n = a.exponent;
  // Softness of each surface: the depth under a unit of force.
  const double soft_a = std::pow(a.stiffness, -1 / n), soft_b = std::pow(b.stiffness, -1 / n);
  const double sum = soft_a + soft_b, part_a = soft_a / sum, part_b = soft_b / sum;
  return {std::pow(sum, -n), n, a.damping * part_a * part_a + b.damping * part_b * part_b};
}

MeanForce mean_force(const Compliance& compliance, double gap_before, double gap_after, double h) noexcept {
  const MeanForce elastic = mean_elastic_force(compliance, gap_before, gap_after);
  const double c = compliance.damping / h, factor = 1 + c * (gap_before - gap_after);
  if (!(factor > 0)) return {};
  return {elastic.force * factor, elastic.slope * factor + elastic.force * c,
          elastic.slope_before * factor - elastic.force * c};
}

}  // namespace axode
