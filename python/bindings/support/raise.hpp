#pragma once
#include <string>
#include <vector>

#include "axode/model/building/fault.hpp"
#include "python/bindings/support/array.hpp"

/// Throws the exceptions of axode/errors.py.
namespace axode::python {

nb::object fault_object(const Fault& fault);
nb::list fault_list(std::span<const Fault> faults);

/// Throws an error of axode.errors with a sentence, the indices of the states that could not be computed, and
/// the result as far as it was computed.
[[noreturn]] void raise_of_states(const char* error, const std::string& sentence,
                                  const std::vector<std::size_t>& states, Array result);

/// Throws an axode.AssemblyError that contains the best configuration q that was found and its residual.
[[noreturn]] void raise_of_assembly(const std::string& sentence, Array q, double residual);

/// Makes ModelError of the library an axode.ModelError in Python, and UnknownName a KeyError.
void translate_exceptions();

}  // namespace axode::python
