#pragma once
#include <string>

namespace axode {

/// Returns a number in its shortest decimal form that reads back to the same double.
std::string to_text(double x);

}  // namespace axode
