#pragma once
#include <string>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {

/// The range of angles for which a function is right.
enum class Angles { moderate, all };
/// The definition of a function that computes sines and cosines of n angles by polynomials, with errors below
/// 2 ulp up to 1e5 rad. With Angles::all it calls <math.h> for larger ones.
std::string c_sine_cosine(const std::string& name, const Precision& precision, Angles angles);
/// The definition of NAME_lanes, which computes sines and cosines of n angles of any size in each lane.
std::string c_sine_cosine_in_lanes(const std::string& name, const Precision& precision);

}  // namespace axode::codegen
