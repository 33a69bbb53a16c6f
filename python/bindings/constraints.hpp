#pragma once
#include "python/bindings/states/state_function.hpp"

namespace axode::python {

/// Indices of velocities, given in Python by names of joints or by numbers; none if `given` is None. Throws
/// nb::value_error for anything else.
std::vector<int> velocities(const Model& m, nb::handle given, const char* argument);
/// `inverse_dynamics` with additional forces, or with drives: of a model with loops, or as if it had some.
Array closed_inverse_dynamics(const BoundModel& m, const Arguments& given, nb::handle drives,
                              nb::handle forces);
/// Computes `joint_wrenches` of Python under drive forces that only the given drives exert.
Array closed_joint_wrenches(const BoundModel& m, const Arguments& given, nb::handle drives);

}  // namespace axode::python
