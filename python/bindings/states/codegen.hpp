#pragma once
#include <nanobind/nanobind.h>

#include <vector>

#include "axode/codegen.hpp"

namespace axode::python {

/// Reads a list of functions to generate. An entry is a word, or a tuple of the word jacobian, a frame and
/// its representation.
std::vector<codegen::Function> functions_from(const Model& model, nanobind::handle functions);

}  // namespace axode::python
