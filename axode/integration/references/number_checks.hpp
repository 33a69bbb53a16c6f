#pragma once
#include <span>
#include <vector>

#include "axode/model/model.hpp"

/// Checks of the numbers that describe drives and references. They throw std::invalid_argument with the name
/// of the argument, its value and the rule that it violates.
namespace axode {

/// Throws unless all numbers of x are finite.
void check_finite(const char* name, std::span<const double> x);

/// Throws unless the times t are finite and increase.
void check_times(std::span<const double> t);

/// Returns one number for each velocity (nv), from nv numbers or from one number for all velocities. Throws
/// for another size.
std::vector<double> for_each_velocity(const Model& model, const char* name, std::span<const double> given);

}  // namespace axode
