#pragma once
#include <span>

#include "axode/codegen/c/c_source.hpp"

namespace axode::codegen {

/// Writes C source for a model: each of the given functions for one state, with a name NAME that is made of a
/// prefix and the name of the function, and a function for several states, which uses vector extensions of
/// the compiler:
///
///     void NAME_states(long count, const T *const *arguments, T *result, T *scratch,
///                      unsigned char *maybe_singular)
///     const long NAME_scratch
///
/// The states are contiguous. As many states as a register holds, but at most `lanes` (a power of 2), are
/// computed at once; if lanes = 1, no vector registers are used. `scratch` must have NAME_scratch numbers and
/// begin at a cache line. If it is null, states are computed one by one, and results may differ by rounding.
/// `maybe_singular` receives the return value of the function for each state. Angles may have any size.
/// Jacobians are written column by column.
Source states_source(const Model& model, std::span<const Function> functions, bool single_precision,
                     int lanes);

}  // namespace axode::codegen
