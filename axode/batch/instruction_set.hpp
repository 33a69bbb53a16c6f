#pragma once

/// The instruction sets for which batches have kernels. One is chosen at run time.
namespace axode::batch {

enum class InstructionSet { sse2, avx2, avx512 };
/// The best instruction set that this processor has and AXODE_INSTRUCTION_SET allows, see instruction_set().
InstructionSet best_instruction_set();

}  // namespace axode::batch
