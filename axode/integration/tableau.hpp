#pragma once
#include <span>
#include <vector>

namespace axode {

/// The coefficients of an explicit Runge-Kutta method: stage i has the weights a[i] (i numbers) and the time
/// c[i], the step has the weights b. `error`, unless it is empty, is b minus the weights of an embedded
/// method.
struct Tableau {
  int order = 1;
  std::vector<std::vector<double>> a;
  std::vector<double> b, c;
  std::vector<double> error = {};

  int stages() const { return static_cast<int>(b.size()); }
};

/// Throws std::invalid_argument if the sizes do not agree, c is not the row sums of a, or b does not add up
/// to 1.
void check(const Tableau& tableau);

/// Throws std::invalid_argument unless the length of a step is a finite time of more than 0 s.
void check_step(double step);

/// Euler's method, the midpoint rule, Kutta's methods of order 3 and 4, and Dormand's and Prince's of order 5
/// (with an error estimate). Throws std::invalid_argument unless the order is 1 to 5.
const Tableau& runge_kutta(int order);

/// Relative step lengths, with the sum 1, of a composition of steps of a symmetric method of second order
/// that has order 2 (one step), 4 (Suzuki's five) or 6 (Kahan's and Li's nine); some are negative (D8.11).
/// Throws std::invalid_argument for another order.
std::span<const double> symmetric_composition(int order);

}  // namespace axode
