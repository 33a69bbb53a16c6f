#pragma once
#include "axode/scalar/instruction_set.hpp"

/// AXODE_REP is a representation and AXODE_T a scalar type, for which templates are instantiated. The build
/// compiles a source file once for each scalar type if it ends in instantiations for AXODE_T, and once for
/// each representation and scalar type if these name AXODE_REP (cmake/axode_library.cmake); the defaults here
/// are for code editors. `template decltype(f<T>) f<T>;` instantiates f with the parameters of its
/// declaration. AXODE_ENTRY before decltype marks functions that can be compiled for several instruction
/// sets, such as AVX2 and AVX-512; the library chooses one of them when it is loaded.
#ifndef AXODE_REP
#define AXODE_REP BodyFixed
#endif
#ifndef AXODE_T
#define AXODE_T double
#endif
