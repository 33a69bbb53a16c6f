#pragma once

/// Instruction sets that batches have kernels for, chosen at run time.
namespace axode::batch {

enum class InstructionSet { sse2, avx2, avx512 };
/// The best one that this processor has.
InstructionSet best_instruction_set();

}  // namespace axode::batch
