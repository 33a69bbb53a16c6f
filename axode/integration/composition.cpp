#include "axode/integration/composition.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace axode {

std::span<const double> symmetric_composition(int order) {
  static constexpr std::array<double, 1> one{1};
  static const double z = 1 / (4 - std::cbrt(4.0));
  static const std::array<double, 5> suzuki{z, z, 1 - 4 * z, z, z};
  static constexpr double a = 0.39216144400731413928, b = 0.33259913678935943860, c = -0.70624617255763935981,
                          d = 0.08221359629355080023, e = 1 - 2 * (a + b + c + d);
  static constexpr std::array<double, 9> kahan_li{a, b, c, d, e, d, c, b, a};
  switch (order) {
    case 2: return one;
    case 4: return suzuki;
    case 6: return kahan_li;
    default: throw std::invalid_argument("order is " + std::to_string(order) + "; expected 2, 4 or 6");
  }
}

}  // namespace axode
