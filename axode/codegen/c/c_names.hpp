#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/codegen/c/c_source.hpp"

/// The names and comments in generated C.
namespace axode::codegen {

/// The default prefix of all names in generated C: the name of the model as an identifier.
std::string prefix_for(const Model& model, Abi abi);

/// The name of each frame of the model as a C identifier. A number is appended to an identifier that would
/// otherwise equal another one. The identifiers also remain distinct if the name of a representation, such as
/// _spatial, is appended to some of them, as function_names() does for Jacobians.
std::vector<std::string> frame_identifiers(const Model& model, Abi abi);

/// The names PREFIX_FUNCTION of generated functions. For a pose or a Jacobian the name of the frame is
/// appended; for a Jacobian that is not body-fixed also the representation. Throws std::invalid_argument if
/// two names are equal.
std::vector<std::string> function_names(const Model& model, std::span<const Function> functions,
                                        const std::string& prefix, Abi abi);

/// Changes a text so that it does not begin or end a comment in C.
std::string in_comment(std::string text);
/// A table of the joints and the indices of their coordinates and velocities, for a comment in C.
std::string coordinates(const Model& model);
/// The counts of operations as text: "3 products, 2 sums, ...".
std::string counted(const Operations& count);

}  // namespace axode::codegen
