#pragma once
#include <string>

#include "axode/codegen/c_function.hpp"

namespace axode::codegen {

/// What the functions of a file of CUDA have in common: axode_at, an entry of the state of a thread.
extern const char* const cuda_entries;

/// `extern "C" __global__ void NAME_states(..., int n)`.
std::string cuda_signature(const Recording& recording, const std::string& name, const Precision& precision);
/// The kernel that calls the function NAME in n states, a thread for each.
std::string cuda_kernel(const Recording& recording, const std::string& name, const Precision& precision);

}  // namespace axode::codegen
