#pragma once
#include <cstddef>

namespace axode::batch {

/// Forward dynamics that was generated in C and compiled for one model. A call takes `count` states:
/// `q_v_tau` are three arrays, the contiguous q, v and tau of the states, and `a` receives their contiguous
/// accelerations. `maybe_singular` receives 1 for each state whose mass matrix may be singular, or 0.
template <class S> struct CompiledDynamics {
  void (*call)(long count, const S* const* q_v_tau, S* a, S* scratch,
               unsigned char* maybe_singular) = nullptr;
  std::size_t scratch = 0;  ///< length (in numbers) of the memory `scratch` that a call for several states
                            ///< needs
};

}  // namespace axode::batch
