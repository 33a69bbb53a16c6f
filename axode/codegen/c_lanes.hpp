#pragma once
#include <string>

#include "axode/codegen/c_function.hpp"

namespace axode::codegen {

/// The types axode_lanes and axode_mask, AXODE_LANES states at once of which there are at most `lanes`, what is computed with
/// them, and how states become lanes and back; nothing where a register holds one number only.
std::string c_lanes(const Precision& precision, int lanes, bool with_math_library);

/// The definition of NAME_states, and of NAME_scratch, for a function that is there by itself and in lanes.
struct StatesFunction {
  std::string name;
  std::vector<int> arguments;  ///< how many numbers each has
  int results, scratch;        ///< how many there are; numbers that the function in lanes keeps
  bool returns_singularity;
};
std::string c_states(const StatesFunction& function, const Precision& precision, int lanes);

}  // namespace axode::codegen
