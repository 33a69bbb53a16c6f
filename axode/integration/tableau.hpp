#pragma once
#include <span>
#include <vector>

namespace axode {

/// The coefficients of an explicit Runge-Kutta method (its Butcher tableau): a[i] has the weights of the i
/// stages before stage i, c[i] is the time of stage i in units of the step, and b has the weights of all
/// stages. `error`, unless it is empty, is b minus the weights of an embedded method.
struct Tableau {
  int order = 1;
  std::vector<std::vector<double>> a;
  std::vector<double> b, c;
  std::vector<double> error = {};

  int stages() const { return static_cast<int>(b.size()); }
};

/// Throws std::invalid_argument if sizes do not agree, c is not the row sums of a, or b does not add up to 1.
void check(const Tableau& tableau);

/// Checks the length of a step (s). Throws std::invalid_argument unless it is finite and greater than 0.
void check_step(double step);

/// The explicit Runge-Kutta method of an order: Euler's (1), the midpoint rule (2), Kutta's (3 and 4), or
/// Dormand's and Prince's with an error estimate (5). Throws std::invalid_argument for other orders.
const Tableau& runge_kutta(int order);

/// The lengths, in units of the whole step, of the steps of a symmetric method of second order whose
/// composition has order 2 (one step), 4 (Suzuki's five steps) or 6 (Kahan's and Li's nine steps). Their sum
/// is 1, and some are negative (D8.11). Throws std::invalid_argument for another order.
std::span<const double> symmetric_composition(int order);

}  // namespace axode
