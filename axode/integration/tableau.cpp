#include "axode/integration/tableau.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/model/building/fault.hpp"
#include "axode/scalar/text.hpp"

namespace axode {

void check(const Tableau& tableau) {
  const std::size_t s = tableau.b.size();
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("tableau: " + what); };
  if (s == 0) refuse("b is empty; a method has at least one stage");
  if (tableau.a.size() != s || tableau.c.size() != s || (!tableau.error.empty() && tableau.error.size() != s))
    refuse("b has " + std::to_string(s) + " numbers; a, c and error must have as many");
  double weights = 0;
  for (std::size_t i = 0; i < s; ++i) {
    if (tableau.a[i].size() != i)
      refuse("a[" + std::to_string(i) + "] has " + std::to_string(tableau.a[i].size()) +
             " numbers; in an explicit method it has " + std::to_string(i));
    double sum = 0;
    for (const double x : tableau.a[i]) sum += x;
    if (!(std::abs(sum - tableau.c[i]) <= 1e-12))
      refuse("c[" + std::to_string(i) + "] is " + to_text(tableau.c[i]) + "; a[" + std::to_string(i) +
             "] adds up to " + to_text(sum));
    weights += tableau.b[i];
  }
  if (!(std::abs(weights - 1) <= 1e-12)) refuse("b adds up to " + to_text(weights) + "; expected 1");
}

void check_step(double step) {
  if (!(step > 0) || !std::isfinite(step))
    throw std::invalid_argument("step is " + to_text(step) + " s; expected a finite time of more than 0 s");
}

const Tableau& runge_kutta(int order) {
  static const std::array<Tableau, 5> all{
      Tableau{1, {{}}, {1}, {0}}, Tableau{2, {{}, {0.5}}, {0, 1}, {0, 0.5}},
      Tableau{3, {{}, {0.5}, {-1, 2}}, {1 / 6., 2 / 3., 1 / 6.}, {0, 0.5, 1}},
      Tableau{4, {{}, {0.5}, {0, 0.5}, {0, 0, 1}}, {1 / 6., 1 / 3., 1 / 3., 1 / 6.}, {0, 0.5, 0.5, 1}},
      Tableau{5,
              {{},
               {1 / 5.},
               {3 / 40., 9 / 40.},
               {44 / 45., -56 / 15., 32 / 9.},
               {19372 / 6561., -25360 / 2187., 64448 / 6561., -212 / 729.},
               {9017 / 3168., -355 / 33., 46732 / 5247., 49 / 176., -5103 / 18656.},
               {35 / 384., 0, 500 / 1113., 125 / 192., -2187 / 6784., 11 / 84.}},
              {35 / 384., 0, 500 / 1113., 125 / 192., -2187 / 6784., 11 / 84., 0},
              {0, 1 / 5., 3 / 10., 4 / 5., 8 / 9., 1, 1},
              {71 / 57600., 0, -71 / 16695., 71 / 1920., -17253 / 339200., 22 / 525., -1 / 40.}}};
  if (order < 1 || order > 5)
    throw std::invalid_argument("order is " + std::to_string(order) + "; expected 1 to 5");
  return all[static_cast<std::size_t>(order - 1)];
}

std::span<const double> symmetric_composition(int order) {
  static constexpr std::array<double, 1> one{1};
  static const double z = 1 / (4 - std::cbrt(4.0));
  static const std::array<double, 5> suzuki{z, z, 1 - 4 * z, z, z};
  static constexpr double a = 0.39216144400731413928, b = 0.33259913678935943860;
  static constexpr double c = -0.70624617255763935981, d = 0.08221359629355080023;
  static constexpr double e = 1 - 2 * (a + b + c + d);
  static constexpr std::array<double, 9> kahan_li{a, b, c, d, e, d, c, b, a};
  switch (order) {
    case 2: return one;
    case 4: return suzuki;
    case 6: return kahan_li;
    default: throw std::invalid_argument("order is " + std::to_string(order) + "; expected 2, 4 or 6");
  }
}

}  // namespace axode
