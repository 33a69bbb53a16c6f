#pragma once
#include <string>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {

/// Defines the types axode_lanes and axode_mask for AXODE_LANES states at once, at most `lanes`, operations
/// on them, and the transposition of states to lanes and back. The definitions are empty if a register holds
/// one number only.
std::string c_lanes(const Precision& precision, int lanes, bool with_math_library);

/// A function that is defined for one state and for lanes.
struct StatesFunction {
  std::string name;
  std::vector<int> arguments;  ///< length of each argument
  int results, scratch;        ///< number of results, and length of the memory `scratch` of the function for
                               ///< lanes
  bool returns_singularity;
};
/// The definitions of NAME_states and NAME_scratch.
std::string c_states(const StatesFunction& function, const Precision& precision, int lanes);

}  // namespace axode::codegen
