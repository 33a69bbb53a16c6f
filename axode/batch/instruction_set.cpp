#include "axode/batch/instruction_set.hpp"

#include "axode/batch.hpp"

namespace axode::batch {

InstructionSet best_instruction_set() {
  static const InstructionSet best = [] {
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
      return InstructionSet::avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::avx2;
    return InstructionSet::sse2;
  }();
  return best;
}

const char* instruction_set() {
  switch (best_instruction_set()) {
    case InstructionSet::avx512: return "AVX-512";
    case InstructionSet::avx2: return "AVX2";
    case InstructionSet::sse2: break;
  }
  return "SSE2";
}

}  // namespace axode::batch
