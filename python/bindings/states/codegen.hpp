#pragma once
#include <nanobind/nanobind.h>

#include <vector>

#include "axode/codegen.hpp"

namespace axode::python {

/// Reads a list of functions of the model for which code is to be generated. An entry is a name, or a tuple
/// ("jacobian", frame), ("jacobian", frame, representation) or ("pose", frame).
std::vector<codegen::Function> functions_from(const Model& model, nanobind::handle functions);

}  // namespace axode::python
