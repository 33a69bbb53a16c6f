#pragma once
#include "axode/scalar/instruction_set.hpp"

/// Source files that end in `template ... AXODE_T` are compiled once for each scalar, and those that name
/// AXODE_REP once for each representation and scalar (see cmake/axode_library.cmake), because many
/// instantiations in one translation unit exhaust a compiler's inlining budget and double the run time.
/// AXODE_ENTRY marks instantiations that are compiled for each instruction set. An editor, which does not run
/// the build, uses these defaults:
#ifndef AXODE_REP
#define AXODE_REP BodyFixed
#endif
#ifndef AXODE_T
#define AXODE_T double
#endif
