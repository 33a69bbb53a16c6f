#pragma once
#include <string>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {

/// The range of angles for which a function computes sines and cosines: up to 1e5 rad, or all angles.
enum class Angles { moderate, all };
/// The definition in C of a function that computes sines and cosines of n angles by polynomials, with errors
/// below 2 ulp up to 1e5 rad. If `angles` is Angles::all, it calls <math.h> for larger angles.
std::string c_sine_cosine(const std::string& name, const Precision& precision, Angles angles);
/// The definition in C of NAME_lanes: sines and cosines of n angles of any size for each SIMD lane.
std::string c_sine_cosine_in_lanes(const std::string& name, const Precision& precision);

}  // namespace axode::codegen
