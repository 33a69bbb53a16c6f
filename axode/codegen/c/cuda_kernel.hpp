#pragma once
#include <string>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {

/// The CUDA function axode_at, which accesses an entry of the state of a thread; every file begins with it.
extern const char* const cuda_entries;

/// Writes the device function that one thread calls to compute one of n states, which lie side by side in
/// memory.
Definition cuda_definition(const Recording& recording, const std::string& name, const Precision& precision);
/// Writes the kernel `NAME_states(..., int n)`, which calls the device function NAME for n states, with a
/// thread for each state.
std::string cuda_kernel(const Recording& recording, const std::string& name, const Precision& precision);

}  // namespace axode::codegen
