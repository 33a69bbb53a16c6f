#pragma once
#include <cstddef>

namespace axode {

/// Converts an index of Eigen or of a mechanism's tables, which is signed, to one of the standard containers.
constexpr std::size_t index(std::ptrdiff_t k) noexcept { return static_cast<std::size_t>(k); }

}  // namespace axode
