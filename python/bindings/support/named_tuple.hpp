#pragma once
#include "python/bindings/support/array.hpp"

namespace axode::python {

/// Makes an object of a typing.NamedTuple that one of the package's modules defines.
template <class... Entry> nb::object named_tuple(const char* module, const char* type, Entry&&... entries) {
  return nb::module_::import_(module).attr(type)(nb::cast(std::forward<Entry>(entries))...);
}
/// Makes an object of a typing.NamedTuple of axode.records.
template <class... Entry> nb::object record(const char* type, Entry&&... entries) {
  return named_tuple("axode.records", type, std::forward<Entry>(entries)...);
}

}  // namespace axode::python
