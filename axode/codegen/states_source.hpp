#pragma once
#include <span>

#include "axode/codegen/c_source.hpp"

namespace axode::codegen {

/// What c_source writes, and behind each function NAME one for many states, for compilers with vector extensions:
///
///     void NAME_states(long count, const T *const *arguments, T *result, T *scratch, unsigned char *maybe_singular)
///     const long NAME_scratch
///
/// States lie one behind the other. As many as a register holds, but at most `lanes` (a power of 2), are computed at once;
/// 1 is for no such registers. `scratch` has NAME_scratch numbers from a cache line on; without it states are computed one by
/// one, which may differ by rounding. `maybe_singular` has an entry for each state: what the function returns. Angles may have any
/// size; Jacobians are written column by column.
Source states_source(const Model& model, std::span<const Function> functions, bool single_precision,
                     int lanes);

}  // namespace axode::codegen
