#pragma once
#include <span>
#include <vector>

#include "axode/model/model.hpp"

/// Checks of the numbers that describe drives and references. They throw std::invalid_argument with the name
/// of the argument, the value and the rule.
namespace axode {

/// All numbers must be finite.
void check_finite(const char* name, std::span<const double> x);

/// Times must be finite and increase.
void check_times(std::span<const double> t);

/// One number for each velocity, from nv numbers or from one number for all.
std::vector<double> for_each_velocity(const Model& model, const char* name, std::span<const double> given);

}  // namespace axode
