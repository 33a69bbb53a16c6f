#pragma once
#include <nanobind/nanobind.h>

#include <vector>

#include "axode/codegen.hpp"

namespace axode::python {

/// Parses a list of requests for generated code: names of functions, or tuples ("jacobian", frame),
/// ("jacobian", frame, representation) or ("pose", frame).
std::vector<codegen::Function> functions_from(const Model& model, nanobind::handle functions);

}  // namespace axode::python
