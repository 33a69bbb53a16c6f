#pragma once
#include <cstddef>

namespace axode::batch {

/// Forward dynamics that was compiled for a model, of `count` states: q, v and tau lie one state behind the
/// other, and so do the accelerations; maybe_singular has a 1 for each whose mass matrix may be singular. See
/// codegen/states_source.hpp.
template <class S> struct CompiledDynamics {
  void (*call)(long count, const S* const* q_v_tau, S* a, S* scratch,
               unsigned char* maybe_singular) = nullptr;
  std::size_t scratch = 0;  ///< numbers that it needs for several states at once
};
}  // namespace axode::batch
