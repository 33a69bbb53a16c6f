#pragma once
#include <vector>

#include "axode/model/building/builder.hpp"

namespace axode {

/// Finds all errors and warnings about a description that can be found without compiling it. The description
/// may have any numbers and names.
std::vector<Fault> inspect(const Description& description, Strictness strictness);

}  // namespace axode
