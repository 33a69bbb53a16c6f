#pragma once
#include "axode/codegen/c/c_source.hpp"
#include "axode/codegen/compiled/specialised.hpp"

/// Functions of one mechanism as generated C source, and as machine code that is compiled at run time.
