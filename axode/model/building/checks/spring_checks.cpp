#include "axode/model/building/checks/spring_checks.hpp"

#include <cmath>

#include "axode/model/building/spring_laws.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace {

bool is_finite(const FaultySubject& at, const LinearCurve& curve) {
  return are_finite(at, {{"stiffness", curve.stiffness}});
}
bool is_finite(const FaultySubject& at, const PolynomialCurve& curve) {
  return are_finite(at, "coefficients", curve.coefficients);
}
bool is_finite(const FaultySubject& at, const TableCurve& curve) {
  return are_finite(at, "deflections", curve.deflections) && are_finite(at, "forces", curve.forces);
}
bool is_finite(const FaultySubject& at, const GasCurve& gas) {
  return are_finite(at, {{"area", gas.area},
                         {"pressure", gas.pressure},
                         {"volume", gas.volume},
                         {"exponent", gas.exponent},
                         {"ambient", gas.ambient}});
}

/// Whether all numbers of a spring are finite. Reports the first one that is not.
bool numbers_are_finite(const FaultySubject& at, const SpringDescription& spring) {
  if (!are_finite(at, {{"points[0]", spring.points[0]}, {"points[1]", spring.points[1]}}) ||
      !are_finite(at, {{"stiffness", spring.stiffness},
                       {"rest", spring.rest},
                       {"damping", spring.damping},
                       {"preload", spring.preload.value_or(0)}}))
    return false;
  for (const SpringDescription::Point& it : spring.path)
    if (!are_finite(at, {{"a point of its path", it.point}})) return false;
  for (const auto& [joint, factor] : spring.terms)
    if (!finite(factor)) {
      at.error(Rule::non_finite_number,
               "the factor of joint " + quoted(joint) + " is " + to_text(factor) + "; it must be finite");
      return false;
    }
  for (std::size_t k = 0; k < 6; ++k)
    if (const std::string row = '[' + std::to_string(k) + ']';
        !are_finite(at, "stiffness" + row, spring.K[k]) || !are_finite(at, "damping" + row, spring.C[k]))
      return false;
  return !spring.curve || std::visit([&](const auto& curve) { return is_finite(at, curve); }, *spring.curve);
}

bool check_curve(const FaultySubject& at, const LinearCurve& curve) {
  not_negative(at, {{"stiffness", curve.stiffness}});
  return curve.stiffness >= 0;
}
bool check_curve(const FaultySubject& at, const PolynomialCurve& curve) {
  if (curve.coefficients.empty())
    at.error(Rule::missing_element, "has no coefficients; give those of 1, x, x^2, ... in its law");
  return !curve.coefficients.empty();
}
bool check_curve(const FaultySubject& at, const TableCurve& curve) {
  const std::size_t n = curve.deflections.size();
  if (n != curve.forces.size() || n < 2) {
    at.error(Rule::wrong_value, "has " + std::to_string(n) + " deflections and " +
                                    std::to_string(curve.forces.size()) +
                                    " forces; its law needs two points or more, each with both");
    return false;
  }
  for (std::size_t k = 1; k < n; ++k)
    if (!(curve.deflections[k] > curve.deflections[k - 1])) {
      at.error(Rule::wrong_value, "has the deflection " + to_text(curve.deflections[k]) + " after " +
                                      to_text(curve.deflections[k - 1]) + "; deflections must increase");
      return false;
    }
  return true;
}
bool check_curve(const FaultySubject& at, const GasCurve& gas) {
  bool good = true;
  for (const auto& [what, value] : {std::pair{"area", gas.area}, std::pair{"pressure", gas.pressure},
                                    std::pair{"volume", gas.volume}, std::pair{"exponent", gas.exponent}}) {
    if (value > 0) continue;
    at.error(Rule::wrong_value,
             std::string("the ") + what + " of its gas is " + to_text(value) + "; it must be positive");
    good = false;
  }
  not_negative(at, {{"the pressure around its gas", gas.ambient}});
  return good && gas.ambient >= 0;
}

/// Checks the preload of a spring whose curve has no faults, and warns if a one-sided force jumps at 0.
void check_force(const FaultySubject& at, const SpringDescription& spring) {
  const bool tension = spring.acts == Acts::in_tension;
  if (spring.acts != Acts::both_ways) {
    const ForceLaw law = force_law(spring);
    const double jump = curve_value(law, 0.0).f;
    if (jump != 0)
      at.warning(Rule::wrong_value, "its force jumps to " + to_text(jump) +
                                        " where it begins to act; let its law begin with 0, or model it as a "
                                        "stop");
  }
  if (!spring.preload) return;
  const double F = *spring.preload;
  if (spring.rest != 0)
    at.error(Rule::wrong_value, "has a rest of " + to_text(spring.rest) + " and a preload of " + to_text(F) +
                                    "; the preload says where it rests: give one of both");
  if (spring.curve && std::holds_alternative<GasCurve>(*spring.curve))
    at.error(Rule::wrong_value,
             "has a gas and a preload of " + to_text(F) + "; the pressure of the gas is its preload");
  if (spring.acts != Acts::both_ways && (tension ? F < 0 : F > 0))
    at.error(Rule::wrong_value,
             "has a preload of " + to_text(F) + " and acts in " +
                 (tension ? "tension, which is positive" : "compression, which is negative"));
  if (!spring.curve && !(spring.stiffness > 0))
    at.error(Rule::wrong_value,
             "has a preload of " + to_text(F) + " and no stiffness; without one it has no preload");
}

constexpr double matrix_tolerance = 1e-9;

/// Whether a symmetric matrix with diagonal entries of 1 or 0 has a negative eigenvalue, by Gaussian pivots.
bool has_negative_eigenvalue(SixBySix A) {
  for (std::size_t k = 0; k < 6; ++k) {
    const double pivot = A[k][k];
    if (pivot < -matrix_tolerance) return true;
    for (std::size_t l = k + 1; l < 6; ++l) {
      if (pivot <= matrix_tolerance) {
        if (A[l][k] * A[l][k] > matrix_tolerance) return true;
        continue;
      }
      const double factor = A[l][k] / pivot;
      for (std::size_t m = k + 1; m < 6; ++m) A[l][m] -= factor * A[k][m];
    }
  }
  return false;
}

/// Checks the stiffness or damping matrix A of a bushing: it must be symmetric and have no negative
/// eigenvalue. As its rows have different units, it is scaled first.
void check_matrix(const FaultySubject& at, const std::string& what, const SixBySix& A) {
  SixBySix scaled{};
  for (std::size_t k = 0; k < 6; ++k)
    if (A[k][k] < 0)
      return at.error(Rule::negative_value, "its " + what + " has " + to_text(A[k][k]) +
                                                " on the diagonal; it must not be negative");
  for (std::size_t k = 0; k < 6; ++k)
    for (std::size_t l = 0; l < 6; ++l) {
      const double size = std::sqrt(A[k][k]) * std::sqrt(A[l][l]);
      if (!(std::abs(A[k][l] - A[l][k]) <= matrix_tolerance * size))
        return at.error(Rule::wrong_value, "its " + what + " is not symmetric; entries " +
                                               std::to_string(k + 1) + ", " + std::to_string(l + 1) +
                                               " are " + to_text(A[k][l]) + " and " + to_text(A[l][k]));
      if (size > 0)
        scaled[k][l] = A[k][l] / size;
      else if (A[k][l] != 0)
        return at.error(Rule::wrong_value, "its " + what + " couples a direction that has none");
    }
  if (has_negative_eigenvalue(scaled))
    at.error(Rule::wrong_value, "its " + what + " has a negative eigenvalue; it must not give off energy");
}

}  // namespace

void check_spring(const FaultySubject& at, const SpringDescription& spring) {
  if (!numbers_are_finite(at, spring)) return;
  const SpringTraits& kind = traits(spring.kind);
  if (kind.has("frames")) {
    check_pose(at, "the first frame", spring.frames[0]);
    check_pose(at, "the second frame", spring.frames[1]);
  }
  if (kind.has("path") && spring.path.size() < 2)
    at.error(Rule::missing_element, "has a path of " + std::to_string(spring.path.size()) +
                                        (spring.path.size() == 1 ? " point" : " points") +
                                        "; it needs two or more");
  if (spring.kind == SpringKind::bushing) {
    check_pose(at, "the rest pose", spring.rest_pose);
    check_matrix(at, "stiffness", spring.K);
    return check_matrix(at, "damping", spring.C);
  }
  const bool length = kind.has("points") || kind.has("path");
  not_negative(at, {{"damping", spring.damping}});
  if (length) not_negative(at, {{"rest", spring.rest}});
  const bool curved = std::visit([&](const auto& curve) { return check_curve(at, curve); },
                                 spring.curve.value_or(LinearCurve{spring.stiffness}));
  if (curved) check_force(at, spring);
}

}  // namespace axode
