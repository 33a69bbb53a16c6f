#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/codegen/c_source.hpp"

/// Names and comments in generated C.
namespace axode::codegen {

/// What names begin with if nothing else is asked for: the model's name as an identifier.
std::string prefix_for(const Model& model, Abi abi);

/// The name of each frame as an identifier; where two would be the same, with or without a representation behind them,
/// the later one gets a number.
std::vector<std::string> frame_identifiers(const Model& model, Abi abi);

/// PREFIX_FUNCTION, for Jacobians and poses with the frame, and a representation other than body-fixed, behind it.
/// Throws std::invalid_argument where two are the same.
std::vector<std::string> function_names(const Model& model, std::span<const Function> functions,
                                        const std::string& prefix, Abi abi);

/// A text inside a comment, which it cannot end.
std::string in_comment(std::string text);
/// A table of the joints and their coordinates, for a comment.
std::string coordinates(const Model& model);
/// "3 products, 2 sums, ...".
std::string counted(const Operations& count);

}  // namespace axode::codegen
