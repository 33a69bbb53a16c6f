#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/codegen/c/c_source.hpp"

/// Names and comments in generated C.
namespace axode::codegen {

/// The default prefix of all names: the model's name as an identifier.
std::string prefix_for(const Model& model, Abi abi);

/// The name of each frame as an identifier. If two names would be equal, alone or with a representation
/// appended, the later one gets a number.
std::vector<std::string> frame_identifiers(const Model& model, Abi abi);

/// The names PREFIX_FUNCTION. The names of Jacobians and poses end with the frame, and those of Jacobians
/// also with the representation unless it is the body-fixed one. Throws std::invalid_argument if two names
/// are equal.
std::vector<std::string> function_names(const Model& model, std::span<const Function> functions,
                                        const std::string& prefix, Abi abi);

/// Changes a text so that it does not begin or end a comment in C.
std::string in_comment(std::string text);
/// A table of the joints and their coordinates, for a comment.
std::string coordinates(const Model& model);
/// The counts of operations as text: "3 products, 2 sums, ...".
std::string counted(const Operations& count);

}  // namespace axode::codegen
