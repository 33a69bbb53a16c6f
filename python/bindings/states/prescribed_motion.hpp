#pragma once
#include <nanobind/nanobind.h>

#include <vector>

#include "axode/constraints/prescribed/prescribed_motion.hpp"

namespace axode::python {

namespace nb = nanobind;

/// Prescribed motions from a dict with names of joints and rods as keys and functions of time as values. A
/// function returns the coordinate s of the joint (or the length of the rod) at a time with its derivatives
/// s', s'' and, optionally, s'''.
std::vector<PrescribedMotion> motions_from(nb::handle given);

}  // namespace axode::python
