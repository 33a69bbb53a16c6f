#pragma once
#include <string>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {

/// The definition in CUDA of axode_at, which reads or writes an entry of the state of a thread. Every file in
/// CUDA begins with it.
extern const char* const cuda_entries;

/// Writes the device function that one thread calls to compute one of n states, which lie side by side in
/// memory.
Definition cuda_definition(const Recording& recording, const std::string& name, const Precision& precision);
/// Writes the kernel `NAME_states(..., int n)`, which calls the device function NAME for n states, with a
/// thread for each state.
std::string cuda_kernel(const Recording& recording, const std::string& name, const Precision& precision);

}  // namespace axode::codegen
