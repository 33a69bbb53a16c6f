#pragma once
#include <nanobind/nanobind.h>

#include "axode/integration/drives.hpp"
#include "python/bindings/support/bound_model.hpp"

namespace axode::python {

namespace nb = nanobind;

/// A drive that Python holds, with the model for which it was made.
struct BoundDrive {
  Model model;
  Drive drive;
};

/// Throws nb::value_error if the drive was made for a model with another nq or nv.
void check_drive(const BoundModel& m, const BoundDrive& drive);

}  // namespace axode::python
