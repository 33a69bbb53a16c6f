#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

/// Force laws of springs: the tension F of a spring as a function of the deflection δ = x - rest and of the
/// rate x', where the coordinate x is a length or an angle and `rest` is its value at which the spring is
/// undeformed. A positive tension pulls the ends together.
namespace axode {

/// F = stiffness δ.
struct LinearCurve {
  double stiffness = 0;
};
/// F = Σ coefficients[k] δ^k.
struct PolynomialCurve {
  std::vector<double> coefficients;
};
/// A piecewise cubic through the points (deflections[k], forces[k]) that is monotone between them, after
/// Fritsch and Carlson (D16.3). Before the first and after the last point it is a straight line with the
/// slope of the cubic at this point.
struct TableCurve {
  std::vector<double> deflections, forces;
};
/// A gas in a chamber that pushes its ends apart. At the deflection δ the gas has the volume V = volume +
/// area δ, and the tension is F = -area (pressure (volume/V)^exponent - ambient), see (D16.5).
struct GasCurve {
  double area = 0;           ///< m²
  double pressure = 0;       ///< pressure in the chamber at δ = 0, Pa
  double volume = 0;         ///< volume of the chamber at δ = 0, m³
  double exponent = 1;       ///< polytropic exponent; 1: constant temperature
  double ambient = 101'325;  ///< pressure outside, Pa
};
/// The curves that a force law may have.
using ForceCurve = std::variant<LinearCurve, PolynomialCurve, TableCurve, GasCurve>;

/// Whether a spring exerts forces at all deflections, at positive ones (tension) or negative ones only.
enum class Acts { both_ways, in_tension, in_compression };

/// A force law: the tension F = curve(δ) + damping x' at the deflection δ = x - rest of a coordinate x with
/// the rate x'. A spring can also act in tension only or in compression only; then F is 0 where damping would
/// reverse the sign of curve(δ).
struct ForceLaw {
  ForceCurve curve = {};
  double rest = 0;     ///< coordinate at which the deflection is 0, m or rad
  double damping = 0;  ///< N s/m or N m s/rad
  Acts acts = Acts::both_ways;
  std::vector<double> slopes = {};    ///< slopes of a TableCurve at its points; else empty
  std::vector<double> energies = {};  ///< energies of a TableCurve at its points, 0 at δ = 0
};

/// The value F of a curve at a deflection δ, its derivative by δ, and the energy ∫ F dδ from 0 to δ.
template <class T> struct CurveValue { T f, slope, energy; };

template <class T> CurveValue<T> evaluate(const LinearCurve& curve, const ForceLaw&, const T& x) noexcept {
  const T k = T(curve.stiffness);
  return {k * x, k, T(0.5) * k * x * x};
}

template <class T>
CurveValue<T> evaluate(const PolynomialCurve& curve, const ForceLaw&, const T& x) noexcept {
  CurveValue<T> out{T(0), T(0), T(0)};
  for (std::size_t k = curve.coefficients.size(); k-- > 0;) {
    out.slope = out.slope * x + out.f;
    out.f = out.f * x + T(curve.coefficients[k]);
    out.energy = out.energy * x + T(curve.coefficients[k] / static_cast<double>(k + 1));
  }
  out.energy = out.energy * x;
  return out;
}

/// Evaluates a TableCurve, a cubic between two points or a straight line outside, at the deflection x.
template <class T> CurveValue<T> evaluate(const TableCurve& curve, const ForceLaw& law, const T& x) noexcept {
  const std::vector<double>&at = curve.deflections, &F = curve.forces;
  const auto next = std::upper_bound(at.begin(), at.end(), x, [](const T& a, double b) { return a < T(b); });
  const auto n = static_cast<std::size_t>(next - at.begin());
  const std::size_t k = n == 0 ? 0 : n - 1;
  const T s = x - T(at[k]), f = T(F[k]), m = T(law.slopes[k]), U = T(law.energies[k]);
  if (n == 0 || n == at.size()) return {f + m * s, m, U + s * (f + T(0.5) * m * s)};
  const double h = at[n] - at[k], secant = (F[n] - F[k]) / h;
  const T c2 = T((3 * secant - 2 * law.slopes[k] - law.slopes[n]) / h),
          c3 = T((law.slopes[k] + law.slopes[n] - 2 * secant) / (h * h));
  return {f + s * (m + s * (c2 + s * c3)), m + s * (T(2) * c2 + T(3) * s * c3),
          U + s * (f + s * (T(0.5) * m + s * (c2 / T(3) + T(0.25) * s * c3)))};
}

/// Evaluates a GasCurve at the deflection x; the results are NaN if the volume is not positive.
template <class T> CurveValue<T> evaluate(const GasCurve& gas, const ForceLaw&, const T& x) noexcept {
  const T A = T(gas.area), V_0 = T(gas.volume), V = V_0 + A * x, n = T(gas.exponent);
  if (!(V > T(0))) {
    const T none = std::numeric_limits<T>::quiet_NaN();
    return {none, none, none};
  }
  const T expansion = -std::log1p(A * x / V_0), p = T(gas.pressure) * std::exp(n * expansion);
  const T excess = n - T(1);
  const T work = excess == T(0) ? expansion : std::expm1(excess * expansion) / excess;
  return {-A * (p - T(gas.ambient)), n * A * A * p / V,
          T(gas.pressure) * V_0 * work + T(gas.ambient) * A * x};
}

/// The tension f of a spring, and its derivatives by the coordinate x and by the rate dx of the coordinate.
template <class T> struct Tension { T f, by_x, by_dx; };

/// Whether a one-sided spring exerts no force at the deflection δ.
template <class T> bool is_slack(const ForceLaw& law, const T& deflection) noexcept {
  return law.acts != Acts::both_ways &&
         !(law.acts == Acts::in_tension ? deflection > T(0) : deflection < T(0));
}

template <class T> CurveValue<T> curve_value(const ForceLaw& law, const T& deflection) noexcept {
  return std::visit([&](const auto& curve) { return evaluate(curve, law, deflection); }, law.curve);
}

/// The tension of a spring at the coordinate x and the rate dx of the coordinate (D16.2).
template <class T> Tension<T> tension(const ForceLaw& law, const T& x, const T& dx) noexcept {
  const T deflection = x - T(law.rest);
  if (is_slack(law, deflection)) return {T(0), T(0), T(0)};
  const CurveValue<T> at = curve_value(law, deflection);
  const T f = at.f + T(law.damping) * dx;
  if (law.acts != Acts::both_ways && f * at.f < T(0)) return {T(0), T(0), T(0)};
  return {f, at.slope, T(law.damping)};
}

/// The energy of a spring at the coordinate x, J; 0 at x = rest.
template <class T> T stored_energy(const ForceLaw& law, const T& x) noexcept {
  const T deflection = x - T(law.rest);
  return is_slack(law, deflection) ? T(0) : curve_value(law, deflection).energy;
}

}  // namespace axode
