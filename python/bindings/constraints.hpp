#pragma once
#include "python/bindings/states/state_function.hpp"

namespace axode::python {

/// Returns indices of velocities, which Python code gives as names of joints or as numbers; an empty list if
/// `given` is None. Throws nb::value_error for all other objects.
std::vector<int> velocities(const Model& m, nb::handle given, const char* argument);
/// `inverse_dynamics` with additional forces, or with drives: of a model with loops, or as if it had some.
Array closed_inverse_dynamics(const BoundModel& m, const Arguments& given, nb::handle drives,
                              nb::handle forces);
/// Computes `joint_wrenches` of Python under drive forces that only the given drives exert.
Array closed_joint_wrenches(const BoundModel& m, const Arguments& given, nb::handle drives);

}  // namespace axode::python
