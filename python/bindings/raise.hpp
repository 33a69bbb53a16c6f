#pragma once
#include <string>
#include <vector>

#include "array.hpp"
#include "axode/model/fault.hpp"

/// The exceptions of axode/errors.py.
namespace axode::python {

nb::object fault_object(const Fault& fault);
nb::list fault_list(std::span<const Fault> faults);

/// Throws axode.SingularError: what it says, the states, and the result as far as there is one.
[[noreturn]] void raise_singular(const std::string& sentence, const std::vector<std::size_t>& states,
                                 Array result);

/// ModelError of the library becomes axode.ModelError, std::domain_error a ValueError.
void translate_exceptions();

}  // namespace axode::python
