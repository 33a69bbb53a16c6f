#pragma once
#include <string>

#include "axode/codegen/c_function.hpp"

namespace axode::codegen {

/// Up to which angles polynomials are used.
enum class Angles { moderate, all };
/// The definition of the function for n angles, errors below 2 ulp up to 1e5 rad; larger ones are left to
/// <math.h> where all angles are wanted.
std::string c_sine_cosine(const std::string& name, const Precision& precision, Angles angles);
/// NAME_lanes, the same for n angles in each lane, of all sizes.
std::string c_sine_cosine_in_lanes(const std::string& name, const Precision& precision);

}  // namespace axode::codegen
