#pragma once
#include <string>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {

/// The CUDA function axode_at, which accesses an entry of the state of a thread; every file begins with it.
extern const char* const cuda_entries;

/// Writes the CUDA device function by which one thread evaluates a recorded function (a list of operations)
/// at one of n states. Entry k of an argument or a result of state i has the index k n + i in memory.
Definition cuda_definition(const Recording& recording, const std::string& name, const Precision& precision);
/// Writes the kernel `NAME_states(..., int n)`, which calls the device function NAME for n states, with a
/// thread for each state.
std::string cuda_kernel(const Recording& recording, const std::string& name, const Precision& precision);

}  // namespace axode::codegen
