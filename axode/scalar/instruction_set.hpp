#pragma once

/// The build compiles kernels for several instruction sets, and the library chooses the code of one set when
/// it is loaded (see cmake/axode_instruction_sets.cmake). AXODE_ENTRY marks the functions whose code is
/// chosen: explicit instantiations, and classes whose members are all instantiated. Other functions in the
/// same sources are invisible outside the code of their set. If code on both sides of an AXODE_ENTRY function
/// uses an object, its layout must not depend on the instruction set; neither must the passing of the
/// arguments of such a function.
#ifdef AXODE_MARK_ENTRIES
#define AXODE_ENTRY __attribute__((visibility("protected")))
#else
#define AXODE_ENTRY
#endif

namespace axode {

/// The instruction set whose code is used: "x86-64", "x86-64-v3" (AVX2, FMA) or "x86-64-v4" (AVX-512). It is
/// the best one that this processor has, unless the environment variable AXODE_INSTRUCTION_SET names another
/// one when the library is loaded. A library that is compiled for one instruction set has its own name for
/// it, such as "native". Throws std::invalid_argument if AXODE_INSTRUCTION_SET has another value, or names a
/// set that this processor does not have; then no model can be built either.
const char* instruction_set();

}  // namespace axode
