#pragma once
#include <span>
#include <vector>

#include "axode/model/model.hpp"

/// Checks of numbers that describe drives and references; they throw std::invalid_argument.
namespace axode {

/// Throws unless all numbers of x are finite.
void check_finite(const char* name, std::span<const double> x);

/// Throws unless the times t are finite and increase.
void check_times(std::span<const double> t);

/// Returns one number for each velocity, from nv numbers or one for all. Throws for another size.
std::vector<double> for_each_velocity(const Model& model, const char* name, std::span<const double> given);

}  // namespace axode
