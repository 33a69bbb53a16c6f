#pragma once
#include <string>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {

/// The definition of axode_at, which reads an entry of the state of a thread. Every file in CUDA begins with
/// it.
extern const char* const cuda_entries;

/// The device function for one thread, which computes one of n states that lie side by side in memory.
Definition cuda_definition(const Recording& recording, const std::string& name, const Precision& precision);
/// The kernel `NAME_states(..., int n)` that calls the function NAME for n states, a thread for each.
std::string cuda_kernel(const Recording& recording, const std::string& name, const Precision& precision);

}  // namespace axode::codegen
