#include "axode/model/building/spring_laws.hpp"

#include <cmath>

namespace axode {
namespace {

/// The slopes, at the points of a table, of a piecewise cubic that is monotone between the points (Fritsch
/// and Carlson). A slope is the mean of the slopes of the two adjacent secants, or 0 if their signs differ or
/// one of them is 0; at the first and last point it is that of the only secant. If the slopes at the ends of
/// an interval are a and b times that of its secant with a² + b² > 9, both are multiplied by 3 / √(a² + b²).
std::vector<double> monotone_slopes(const TableCurve& table) {
  const std::size_t n = table.deflections.size();
  std::vector<double> secants(n - 1), slopes(n);
  for (std::size_t k = 0; k + 1 < n; ++k)
    secants[k] = (table.forces[k + 1] - table.forces[k]) / (table.deflections[k + 1] - table.deflections[k]);
  slopes.front() = secants.front();
  slopes.back() = secants.back();
  for (std::size_t k = 1; k + 1 < n; ++k)
    slopes[k] = secants[k - 1] * secants[k] > 0 ? 0.5 * (secants[k - 1] + secants[k]) : 0;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    if (secants[k] == 0) {
      slopes[k] = slopes[k + 1] = 0;
      continue;
    }
    const double a = slopes[k] / secants[k], b = slopes[k + 1] / secants[k], size = std::hypot(a, b);
    if (!(size > 3)) continue;
    slopes[k] = 3 * a / size * secants[k];
    slopes[k + 1] = 3 * b / size * secants[k];
  }
  return slopes;
}

}  // namespace

ForceLaw force_law(const SpringDescription& spring) {
  ForceLaw law{.curve = spring.curve.value_or(LinearCurve{spring.stiffness}),
               .rest = spring.preload ? 0 : spring.rest,
               .damping = spring.damping,
               .acts = spring.acts};
  const auto* table = std::get_if<TableCurve>(&law.curve);
  if (table == nullptr) return law;
  law.slopes = monotone_slopes(*table);
  law.energies.assign(law.slopes.size(), 0);
  for (std::size_t k = 0; k + 1 < law.slopes.size(); ++k) {
    const double h = table->deflections[k + 1] - table->deflections[k];
    law.energies[k + 1] = law.energies[k] + h * (0.5 * (table->forces[k] + table->forces[k + 1]) +
                                                 h * (law.slopes[k] - law.slopes[k + 1]) / 12);
  }
  const double at_0 = curve_value(law, 0.0).energy;
  for (double& energy : law.energies) energy -= at_0;
  return law;
}

std::optional<double> deflection_at(const ForceLaw& law, double force, double size) {
  if (const auto* linear = std::get_if<LinearCurve>(&law.curve)) {
    if (!(linear->stiffness > 0)) return std::nullopt;
    return force / linear->stiffness;
  }
  const auto open = [&](double x) { return curve_value(law, x).f - force; };
  if (open(0) == 0) return 0;
  constexpr int parts = 256, most_scales = 8;
  double reach = size;
  for (int scale = 0; scale < most_scales; ++scale, reach *= 16)
    for (int k = 1; k <= parts; ++k)
      for (const double side : {1.0, -1.0}) {
        if (law.acts == (side > 0 ? Acts::in_compression : Acts::in_tension)) continue;
        double near = side * reach * (k - 1) / parts, far = side * reach * k / parts;
        if ((open(near) < 0) == (open(far) < 0)) continue;
        for (;;) {
          const double middle = near + (far - near) / 2;
          if (middle == near || middle == far) break;
          ((open(middle) < 0) == (open(near) < 0) ? near : far) = middle;
        }
        return std::abs(open(near)) < std::abs(open(far)) ? near : far;
      }
  return std::nullopt;
}

}  // namespace axode
