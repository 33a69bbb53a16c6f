#include "axode/codegen/cuda_kernel.hpp"

namespace axode::codegen {

const char* const cuda_entries =
    R"(/* Entry k of a state. The offset hides in an instruction: of what compilers see in k * n they make chains of sums, which
   take registers, and far longer to compile. */
template <int k, class X> static __device__ __forceinline__ X &axode_at(X *x, int n) {
#ifdef __CUDA_ARCH__
  long long offset;
  asm("mul.wide.s32 %0, %1, %2;" : "=l"(offset) : "r"(n), "n"(k * (int)sizeof(X)));
  return *(X *)((char *)x + offset);
#else
  return x[(long long)k * n];
#endif
}

)";

std::string cuda_signature(const Recording& recording, const std::string& name, const Precision& precision) {
  Recording kernel;
  kernel.arguments = recording.arguments, kernel.result = recording.result;
  return "extern \"C\" __global__ __launch_bounds__(128) " +
         c_signature(kernel, name + "_states", precision, Width::thread);
}

std::string cuda_kernel(const Recording& recording, const std::string& name, const Precision& precision) {
  std::string call = name + '(';
  for (const std::string& argument : recording.arguments) call += argument + " + i, ";
  call += recording.result + " + i, n)";
  std::string text = cuda_signature(recording, name, precision) +
                     " {\n  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;\n"
                     "  if (i >= (unsigned)n) return;\n";
  if (!recording.returns_singularity) return text + "  " + call + ";\n}\n";
  return text + filled(
                    "  if (@CALL@)\n#pragma unroll 1\n    for (int k = 0; k < @N@; ++k) @Y@[(long long)k * n "
                    "+ i] = @NAN@;\n}\n",
                    {{"CALL", call},
                     {"N", std::to_string(recording.results.size())},
                     {"Y", recording.result},
                     {"NAN", precision.single ? "nanf(\"\")" : "nan(\"\")"}});
}

}  // namespace axode::codegen
