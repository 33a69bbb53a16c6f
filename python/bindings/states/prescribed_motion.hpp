#pragma once
#include <nanobind/nanobind.h>

#include <vector>

#include "axode/constraints/prescribed/prescribed_motion.hpp"

namespace axode::python {

namespace nb = nanobind;

/// Prescribed motions from a dict {name of a joint or rod: function of time}. A function returns the
/// coordinate s of the joint, or length of the rod, and its derivatives s', s'' and optionally s'''.
std::vector<PrescribedMotion> motions_from(nb::handle given);

}  // namespace axode::python
