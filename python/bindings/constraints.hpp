#pragma once
#include "state_function.hpp"

namespace axode::python {

/// `forward_dynamics` and `inverse_dynamics` of a model with loops.
Array closed_forward_dynamics(const BoundModel& m, const Arguments& given);
Array closed_inverse_dynamics(const BoundModel& m, const Arguments& given, nb::handle drives,
                              nb::handle forces);
nb::object closed_forward_dynamics_derivatives(const BoundModel& m, const Arguments& given);

}  // namespace axode::python
