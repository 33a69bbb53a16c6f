#pragma once
#include <vector>

#include "axode/model/building/builder.hpp"

namespace axode {

/// All errors and warnings of a description that can be found before it is compiled.
std::vector<Fault> inspect(const Description& description, Strictness strictness);

}  // namespace axode
