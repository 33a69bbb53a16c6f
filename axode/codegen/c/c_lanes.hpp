#pragma once
#include <string>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {

/// C code that defines the types axode_lanes and axode_mask for AXODE_LANES states at once, operations on
/// these types, and the transposition of contiguous states to lanes and back. AXODE_LANES is the number of
/// lanes of a register, but at most `lanes`. If AXODE_LANES is 1, the preprocessor leaves out the
/// definitions.
std::string c_lanes(const Precision& precision, int lanes, bool with_math_library);

/// Describes a generated function that is defined for one state and for several states in lanes.
struct StatesFunction {
  std::string name;
  std::vector<int> arguments;  ///< length of each argument for one state
  int results, scratch;        ///< number of results, and length of the memory `scratch` of the function for
                               ///< lanes
  bool returns_singularity;
};
/// Makes C code that evaluates the generated function NAME for several given states. The function NAME_states
/// calls NAME, which takes one state, or the version of NAME that takes one state in each SIMD lane. The
/// constant NAME_scratch is the length of the scratch memory that NAME_states needs, in numbers.
std::string c_states(const StatesFunction& function, const Precision& precision, int lanes);

}  // namespace axode::codegen
