#pragma once
#include <nanobind/nanobind.h>

#include "axode/integration/drives.hpp"

namespace axode::python {

namespace nb = nanobind;

/// A drive of one mechanism.
struct BoundDrive {
  Model model;
  Drive drive;
};

/// The motion of an axode.Trajectory; nullptr for anything else.
const Trajectory* motion_in(nb::handle given);

}  // namespace axode::python
