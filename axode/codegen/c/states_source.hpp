#pragma once
#include <span>

#include "axode/codegen/c/c_source.hpp"

namespace axode::codegen {

/// Writes the file of c_source(), and after each function NAME one for many states, for compilers with vector
/// extensions:
///
///     void NAME_states(long count, const T *const *arguments, T *result, T *scratch,
///                      unsigned char *maybe_singular)
///     const long NAME_scratch
///
/// States are contiguous. As many states as a register holds, but at most `lanes` (a power of 2), are
/// computed at once; with lanes = 1 no vector registers are used. `scratch` has NAME_scratch numbers and
/// begins at a cache line. If it is null, states are computed one by one, which may differ by rounding.
/// `maybe_singular` receives the return value of the function for each state. Angles may have any size.
/// Jacobians are written column by column.
Source states_source(const Model& model, std::span<const Function> functions, bool single_precision,
                     int lanes);

}  // namespace axode::codegen
