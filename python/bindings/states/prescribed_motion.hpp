#pragma once
#include <nanobind/nanobind.h>

#include <vector>

#include "axode/constraints/prescribed/prescribed_motion.hpp"

namespace axode::python {

namespace nb = nanobind;

/// The motions of a dict from joints and rods to functions of time that return s, s', s'' and perhaps s'''.
std::vector<PrescribedMotion> motions_from(nb::handle given);

}  // namespace axode::python
