#pragma once
#include "python/bindings/support/array.hpp"

namespace axode::python {

/// Makes an object of a typing.NamedTuple that one of the package's modules defines.
template <class... Entry> nb::object named_tuple(const char* module, const char* type, Entry&&... entries) {
  return nb::module_::import_(module).attr(type)(nb::cast(std::forward<Entry>(entries))...);
}

}  // namespace axode::python
