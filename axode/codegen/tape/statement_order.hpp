#pragma once
#include <vector>

namespace axode::codegen {

/// Returns the n statements of a program without branches in an order in which few results are live at a
/// time, so that few registers are needed. operands[k] are the statements whose results statement k uses. A
/// result is live until the last statement that uses it, or to the end if its statement is in `lasting`. Of
/// the statements whose operands have all been computed, the next one is that after which the fewest results
/// are live. If there are several, it is the one whose last operand was computed most recently. O(n log n).
std::vector<int> order_for_few_registers(const std::vector<std::vector<int>>& operands,
                                         const std::vector<int>& lasting);

}  // namespace axode::codegen
