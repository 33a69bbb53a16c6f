#pragma once
#include <vector>

#include "axode/model/builder.hpp"

namespace axode {

/// Everything that is wrong or doubtful with a description as it stands, before it is compiled.
std::vector<Fault> inspect(const Description& description, Strictness strictness);

}  // namespace axode
