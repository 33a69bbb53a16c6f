#pragma once
#include <vector>

namespace axode::codegen {

/// An order of statements in which few numbers wait at a time, for machines that have nowhere near to keep them.
/// operands[k] are the statements that make what statement k needs; lasting are those whose numbers are needed in the end.
/// Of those that can be next, next is the one that ends the wait of most numbers, and of several such the one that
/// became possible last, so that a branch of the mechanism is done before another is begun. O(n log n).
std::vector<int> order_for_few_registers(const std::vector<std::vector<int>>& operands,
                                         const std::vector<int>& lasting);

}  // namespace axode::codegen
