#pragma once
#include <nanobind/nanobind.h>

#include "axode/integration/drives.hpp"

namespace axode::python {

namespace nb = nanobind;

/// A drive as Python holds it, with the model for which it was made.
struct BoundDrive {
  Model model;
  Drive drive;
};

/// The motion in an axode.Trajectory; null if `given` is anything else.
const Trajectory* motion_in(nb::handle given);

}  // namespace axode::python
