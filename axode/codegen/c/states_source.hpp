#pragma once
#include <span>

#include "axode/codegen/c/c_source.hpp"

namespace axode::codegen {

/// Writes C source for a model. It has two functions for each of the given functions: one for one state,
/// whose name NAME is a prefix followed by the name of the given function, and one for several states, in
/// which T is double or float:
///
///     void NAME_states(long count, const T *const *arguments, T *result, T *scratch,
///                      unsigned char *maybe_singular)
///     const long NAME_scratch
///
/// `arguments` has a pointer for each argument of NAME, to the values of all states, one state after the
/// other; `result` receives the results in the same order. As many states as a SIMD register holds, but at
/// most `lanes` (a power of 2), are computed at once; if lanes = 1, no vector extensions of the compiler are
/// used. `scratch` must have NAME_scratch numbers and begin at a cache line. If it is null, states are
/// computed one by one, and results may differ by rounding. If NAME returns a number (1 if the mass matrix
/// may be singular, otherwise 0), `maybe_singular` receives it for each state. Angles may have any size.
/// Jacobians are written column by column.
Source states_source(const Model& model, std::span<const Function> functions, bool single_precision,
                     int lanes);

}  // namespace axode::codegen
