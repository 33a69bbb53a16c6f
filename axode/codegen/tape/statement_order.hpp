#pragma once
#include <vector>

namespace axode::codegen {

/// Orders statements so that few numbers are live at a time, for processors with slow memory beside their
/// registers. operands[k] are the statements whose results statement k uses; the results of `lasting` are
/// live to the end. Of all statements whose operands are computed, the next one is that after which most
/// numbers are no longer needed. If there are several, it is the one whose operands became available last, so
/// that a branch of the mechanism is completed before another begins. O(n log n).
std::vector<int> order_for_few_registers(const std::vector<std::vector<int>>& operands,
                                         const std::vector<int>& lasting);

}  // namespace axode::codegen
