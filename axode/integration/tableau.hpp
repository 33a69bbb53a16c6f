#pragma once
#include <span>
#include <vector>

namespace axode {

/// The coefficients of an explicit Runge-Kutta method: stage i is reached with a[i], i numbers, at c[i]; the step with b.
/// Where `error` is not empty, it has b less the weights of an embedded method.
struct Tableau {
  int order = 1;
  std::vector<std::vector<double>> a;
  std::vector<double> b, c;
  std::vector<double> error = {};

  int stages() const { return static_cast<int>(b.size()); }
};

/// Throws std::invalid_argument where the sizes do not fit, c is not the row sums of a, or b does not add up to 1.
void check(const Tableau& tableau);

/// Throws std::invalid_argument where the length of a step is not a finite time of more than 0 s.
void check_step(double step);

/// Euler, the midpoint rule, Kutta's third and fourth order, and Dormand's and Prince's fifth (with an error estimate). Throws
/// std::invalid_argument for another order than 1 to 5.
const Tableau& runge_kutta(int order);

/// The lengths, adding up to 1, of the steps by a symmetric method of second order that make one of order 2 (one step), 4
/// (Suzuki's five) or 6 (Kahan's and Li's nine); some go backwards. Throws std::invalid_argument for another order.
std::span<const double> symmetric_composition(int order);

}  // namespace axode
