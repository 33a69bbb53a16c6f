#include "axode/batch/instruction_set.hpp"

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "axode/batch.hpp"

namespace axode::batch {
namespace {

constexpr const char* names[]{"SSE2", "AVX2", "AVX-512"};

bool processor_has(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
             __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
    case InstructionSet::avx2: return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case InstructionSet::sse2: break;
  }
  return true;
}

/// The instruction set that AXODE_INSTRUCTION_SET names, or the last one if the variable is not set.
InstructionSet best_allowed() {
  const char* allowed = std::getenv("AXODE_INSTRUCTION_SET");
  if (allowed == nullptr) return InstructionSet::avx512;
  for (const InstructionSet set : {InstructionSet::sse2, InstructionSet::avx2, InstructionSet::avx512})
    if (std::string(allowed) == names[static_cast<int>(set)]) return set;
  throw std::invalid_argument("AXODE_INSTRUCTION_SET is \"" + std::string(allowed) +
                              "\"; it must be SSE2, AVX2 or AVX-512");
}

}  // namespace

InstructionSet best_instruction_set() {
  static const InstructionSet best = [] {
    InstructionSet set = best_allowed();
    while (!processor_has(set)) set = static_cast<InstructionSet>(static_cast<int>(set) - 1);
    return set;
  }();
  return best;
}

const char* instruction_set() { return names[static_cast<int>(best_instruction_set())]; }

}  // namespace axode::batch
