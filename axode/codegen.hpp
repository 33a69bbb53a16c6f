#pragma once
#include "axode/codegen/c/c_source.hpp"
#include "axode/codegen/compiled/specialised.hpp"

/// Code for one mechanism: its C source, and functions compiled from it at run time.
