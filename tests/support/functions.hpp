#pragma once
#include <vector>

#include "axode/catalog.hpp"
#include "tests/support/subject.hpp"

/// The functions of the catalogue as they are called, on memory in the scalar of a case.
namespace axode::test {

template <class T> std::span<const catalog::Function<T>> functions_of(const Case& c);

/// The scalar of a case: law(double()) or law(float()).
template <class F> auto with_scalar(const Case& c, const F& law) {
  return c.single ? law(float()) : law(double());
}

/// Memory of arguments for every function.
template <class T> struct Arguments {
  explicit Arguments(const Ask& ask);
  /// Any state under any forces, with one load at least and with losses, and two frames of the model.
  Arguments(const Model& model, Random<double>& random);

  std::vector<T> q, v, a, tau, p, dq, dv, da, dtau, w;
  std::vector<AppliedWrench<T>> wrenches;
  bool joint_losses;
  Place<T> place, base;
  CoriolisForm form = CoriolisForm::christoffel;

  /// To be read as long as these arguments are.
  catalog::Arguments<T> given() const;
};

/// The inputs of numbers that a function takes.
template <class T> std::vector<catalog::Input> inputs_of_numbers(const catalog::Function<T>& function) {
  std::vector<catalog::Input> taken;
  for (const catalog::Input input : catalog::inputs_of_numbers)
    if (function.takes_input(input)) taken.push_back(input);
  return taken;
}

}  // namespace axode::test
