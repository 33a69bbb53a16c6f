#pragma once
#include <nanobind/nanobind.h>

#include <string>

#include "python/bindings/support/bound_model.hpp"

/// The objects behind the classes Joint and Body of Python, and the functions that bind parts of the class Model.
namespace axode::python {

/// A joint that Python holds, with its model, from which the names of its indices follow.
struct BoundJoint {
  const BoundModel* model;
  int i;
  const Joint& operator*() const { return (*model)->joint(i); }
};
struct BoundBody {
  const BoundModel* model;
  int i;
  const Body& operator*() const { return (*model)->body(i); }
};

/// The number as text with six significant digits.
std::string rounded(double x);
/// The range of n indices from `first` on as text, such as `3:6`; `-` if it is empty.
std::string indices(int first, int n);

void add_joint_and_body(nb::module_& module);
void add_configurations(nb::class_<BoundModel>& model);

}  // namespace axode::python
