#pragma once
#include <vector>

#include "axode/fmi/variables.hpp"

namespace axode::fmi {

/// The numbers of a mechanism that are parameters of its FMU: gravity, mass properties of bodies, points of
/// joints (if given in the inertial frame at q = 0), elastic constants and damping of joints, and constants
/// of linear springs. `description` must have been read from a drawing (a mechanism in the TOML format of
/// this library) that write_drawing() has written.
std::vector<Parameter> parameters_of(const Description& description, const Settings& settings);

}  // namespace axode::fmi
