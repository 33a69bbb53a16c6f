#pragma once
#include <nanobind/nanobind.h>

#include <optional>
#include <span>

#include "axode/integration/drives.hpp"
#include "axode/integration/trajectory.hpp"

namespace axode::python {

/// A motion, and its states that Python sees: at given times (`samples`), or else at the ends of its steps.
struct BoundTrajectory {
  Trajectory motion;
  std::optional<Trajectory> samples;

  const Trajectory& shown() const { return samples ? *samples : motion; }
  /// Interpolates the motion at the given times, as far as these are within it. `calls_back` says whether the
  /// drive is a function of Python.
  void sample(std::span<const double> times, const Drive& drive, bool calls_back);
};

/// The motion that an axode.Trajectory holds; null if `given` is another object.
const Trajectory* motion_in(nanobind::handle given);
/// The states that an axode.Trajectory shows; null if `given` is another object.
const Trajectory* shown_in(nanobind::handle given);
/// An axode.Trajectory that holds the motion.
nanobind::object bound_trajectory(Trajectory motion);

void add_trajectory(nanobind::module_& module);

}  // namespace axode::python
