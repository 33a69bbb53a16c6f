#pragma once
#include "axode/scalar/instruction_set.hpp"

/// The build defines AXODE_REP and AXODE_T (see cmake/axode_library.cmake); the defaults here are for code
/// editors. Source files that end in `template ... AXODE_T` are compiled once for each scalar type, and those
/// that name AXODE_REP once for each representation and scalar type. AXODE_ENTRY marks instantiations that
/// can be compiled once for each of several instruction sets, such as AVX2 and AVX-512; the library then
/// chooses one when it is loaded. `template decltype(f<T>) f<T>;` instantiates f with the parameters of its
/// declaration.
#ifndef AXODE_REP
#define AXODE_REP BodyFixed
#endif
#ifndef AXODE_T
#define AXODE_T double
#endif
