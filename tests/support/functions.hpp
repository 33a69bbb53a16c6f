#pragma once
#include <vector>

#include "axode/catalog.hpp"
#include "tests/support/subject.hpp"

/// Calls of the functions of the catalogue, with memory for their arguments in the scalar type of a case.
namespace axode::test {

template <class T> std::span<const catalog::Function<T>> functions_of(const Case& c);

/// Calls law(double()) or law(float()), after the scalar type of a case.
template <class F> auto with_scalar(const Case& c, const F& law) {
  return c.single ? law(float()) : law(double());
}

/// Arguments for every function of the catalogue, with the memory that holds their numbers.
template <class T> struct Arguments {
  explicit Arguments(const Ask& ask);
  /// A random state of the model under random forces, with at least one load and with losses, and two frames
  /// of the model.
  Arguments(const Model& model, Random<double>& random);

  std::vector<T> q, v, a, tau, p, dq, dv, da, dtau, w;
  std::vector<AppliedWrench<T>> wrenches;
  bool joint_losses;
  Place<T> place, base;
  CoriolisForm form = CoriolisForm::christoffel;

  /// Views of these arguments, as the catalogue takes them; they are valid as long as this object is.
  catalog::Arguments<T> given() const;
};

/// The inputs of a function that are arrays of numbers.
template <class T> std::vector<catalog::Input> inputs_of_numbers(const catalog::Function<T>& function) {
  std::vector<catalog::Input> taken;
  for (const catalog::Input input : catalog::inputs_of_numbers)
    if (function.takes_input(input)) taken.push_back(input);
  return taken;
}

}  // namespace axode::test
