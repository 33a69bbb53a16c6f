#pragma once
#include <vector>

namespace axode::codegen {

/// Orders statements such that few results are live at a time, for processors whose memory is slow compared
/// with their registers. operands[k] are the statements whose results statement k uses; the results of the
/// statements `lasting` are live to the end. The next statement is always the one, of all whose operands have
/// been computed, after which the fewest results are live. If there are several such statements, the one
/// whose operands were computed last is next, so that a branch of the mechanism is completed before another
/// one begins. O(n log n) for n statements.
std::vector<int> order_for_few_registers(const std::vector<std::vector<int>>& operands,
                                         const std::vector<int>& lasting);

}  // namespace axode::codegen
