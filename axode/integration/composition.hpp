#pragma once
#include <span>

namespace axode {

/// The lengths, adding up to 1, of the steps by a symmetric method of second order that make one of order 2 (one step), 4
/// (Suzuki's five) or 6 (Kahan's and Li's nine); some go backwards. Throws std::invalid_argument for another order.
std::span<const double> symmetric_composition(int order);

}  // namespace axode
