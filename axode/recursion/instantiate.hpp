#pragma once
#include "axode/scalar/instruction_set.hpp"

/// Defaults for editors of macros that the build defines (see cmake/axode_library.cmake). Source files that
/// end in `template ... AXODE_T` are compiled once for each scalar, and those that name AXODE_REP once for
/// each representation and scalar. AXODE_ENTRY marks instantiations for each instruction set.
#ifndef AXODE_REP
#define AXODE_REP BodyFixed
#endif
#ifndef AXODE_T
#define AXODE_T double
#endif
