#pragma once
#include <vector>

namespace axode::codegen {

/// Orders statements so that few results are live at a time, for processors whose memory is slow compared
/// with their registers. operands[k] are the statements whose results statement k uses; the results of the
/// statements `lasting` are live to the end. Of all statements whose operands are computed, the next one is
/// that after which the fewest results are live. If there are several, it is the one whose operands became
/// available last, so that a branch of the mechanism is completed before another one begins. O(n log n) for n
/// statements.
std::vector<int> order_for_few_registers(const std::vector<std::vector<int>>& operands,
                                         const std::vector<int>& lasting);

}  // namespace axode::codegen
