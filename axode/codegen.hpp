#pragma once
#include "axode/codegen/c/c_source.hpp"
#include "axode/codegen/compiled/specialised.hpp"

/// Code for one mechanism: functions of the mechanism as C source, and as machine code that is compiled at
/// run time.
