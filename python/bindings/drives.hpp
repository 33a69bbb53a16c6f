#pragma once
#include <nanobind/nanobind.h>

#include "axode/integration/drives.hpp"
#include "python/bindings/support/bound_model.hpp"

namespace axode::python {

namespace nb = nanobind;

/// A drive as Python holds it, with the model for which it was made.
struct BoundDrive {
  Model model;
  Drive drive;
};

/// Throws ValueError if a drive was made for a model of other sizes.
void check_drive(const BoundModel& m, const BoundDrive& drive);

/// The motion in an axode.Trajectory; null if `given` is anything else.
const Trajectory* motion_in(nb::handle given);
/// A motion as an axode.Trajectory.
nb::object bound_trajectory(Trajectory motion);

}  // namespace axode::python
