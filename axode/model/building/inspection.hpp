#pragma once
#include <vector>

#include "axode/model/building/builder.hpp"

namespace axode {

/// Finds all errors and warnings about a description, of any numbers and names, without compiling it.
std::vector<Fault> inspect(const Description& description, Strictness strictness);

}  // namespace axode
