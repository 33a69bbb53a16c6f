#pragma once
#include "python/bindings/states/state_function.hpp"

namespace axode::python {

/// Velocities by the names of joints or by numbers; none where nothing is given. Throws nb::value_error for
/// what is neither.
std::vector<int> velocities(const Model& m, nb::handle given, const char* argument);
/// `inverse_dynamics` with additional forces, or with drives: of a model with loops, or as if it had some.
Array closed_inverse_dynamics(const BoundModel& m, const Arguments& given, nb::handle drives,
                              nb::handle forces);
/// `joint_wrenches` under the drive forces that the given drives exert.
Array closed_joint_wrenches(const BoundModel& m, const Arguments& given, nb::handle drives);

}  // namespace axode::python
