#pragma once
#include <string_view>
#include <vector>

#include "tests/support/subject.hpp"

/// Mechanisms and states in other units of length, mass and time.
namespace axode::test {

/// The powers of length, mass and time in a quantity. Angles have none.
struct Dimension {
  int length = 0, mass = 0, time = 0;

  friend constexpr Dimension operator*(const Dimension& a, const Dimension& b) {
    return {a.length + b.length, a.mass + b.mass, a.time + b.time};
  }
  friend constexpr Dimension operator/(const Dimension& a, const Dimension& b) {
    return {a.length - b.length, a.mass - b.mass, a.time - b.time};
  }
  bool operator==(const Dimension&) const = default;
};
namespace dimension {
inline constexpr Dimension one{}, length{1, 0, 0}, mass{0, 1, 0}, time{0, 0, 1}, velocity{1, 0, -1},
    acceleration{1, 0, -2}, force{1, 1, -2}, energy{2, 1, -2}, rate{0, 0, -1};
}  // namespace dimension

/// The dimension that a text such as "kg m^2/s", "1/(kg m)", "N m s", "J" or "rad" stands for. A word that is
/// no unit fails the test.
Dimension dimension_of(std::string_view unit);

/// The factors by which lengths, masses and times are multiplied. Where they are powers of 4 and a
/// computation has no absolute thresholds, its results are multiplied without any rounding.
struct Units {
  double length = 1, mass = 1, time = 1;

  /// The factor by which a number of a dimension is multiplied.
  double operator()(const Dimension& dimension) const;
};

/// Two lists of dimensions, each of them an angle or a length: of each coordinate (nq entries), and of the
/// quantity of which each velocity is the rate (nv entries).
std::vector<Dimension> coordinate_dimensions(const Model& model);
std::vector<Dimension> direction_dimensions(const Model& model);
/// The dimension of the coordinate of each joint screw (n_screws entries).
std::vector<Dimension> screw_dimensions(const Model& model);

/// The same mechanism in other units. The terms of couplings are taken for angles.
Description in_units(const Units& units, Description description);
/// The arguments of a call in other units. The weights are multiplied by the inverse of `weighed`, the factor
/// of the quantity that they weigh.
Ask in_units(const Units& units, const Model& model, Ask ask);
State<double> in_units(const Units& units, const Model& model, State<double> state);

/// The numbers x, each multiplied by the factor of its own dimension and by that of a common one.
std::vector<double> in_units(const Units& units, std::vector<double> x, const std::vector<Dimension>& each,
                             const Dimension& common = {});

}  // namespace axode::test
