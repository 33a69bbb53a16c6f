#pragma once

/// AXODE_ENTRY marks functions that are compiled for several instruction sets, one of which the library
/// chooses when it is loaded (see cmake/axode_instruction_sets.cmake). It marks explicit instantiations of
/// functions, and classes whose members are all instantiated. Other functions in the same sources cannot be
/// called from code of another set. The way in which marked functions take arguments, and the layout of
/// objects that they share with other code, must not depend on the set.
#ifdef AXODE_MARK_ENTRIES
#define AXODE_ENTRY __attribute__((visibility("protected")))
#else
#define AXODE_ENTRY
#endif

namespace axode {

/// The instruction set whose code is used: "x86-64", "x86-64-v3" (AVX2, FMA) or "x86-64-v4" (AVX-512). It is
/// the best one of this processor, unless the environment variable AXODE_INSTRUCTION_SET names another one
/// when the library is loaded. A library that is compiled for one instruction set has its own name for it,
/// such as "native". Throws std::invalid_argument if the variable has another value, or names a set that this
/// processor does not have; then no model can be built either.
const char* instruction_set();

}  // namespace axode
