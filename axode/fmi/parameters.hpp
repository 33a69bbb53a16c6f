#pragma once
#include <vector>

#include "axode/fmi/variables.hpp"

namespace axode::fmi {

/// The numbers of a description that are parameters of its FMU: gravity, mass properties of bodies, points of
/// joints that are drawn in the construction frame, elasticity and damping of joints, and constants of
/// springs with linear laws. The description must be that of a drawing that was written by write_drawing().
std::vector<Parameter> parameters_of(const Description& description, const Settings& settings);

}  // namespace axode::fmi
